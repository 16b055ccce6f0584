#include "src/service/http/target.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

namespace tessera::service::http {
namespace {

TEST(Target, IsDecodedOnce) {
  const auto target = parse_target("/v1/a%20b/%C3%A9?x=1+2&y=%26");
  ASSERT_TRUE(target);
  EXPECT_EQ(target.value().segments, (std::vector<std::string>{"v1", "a b", "\xc3\xa9"}));
  EXPECT_EQ(target.value().parameter("x"), "1 2");
  EXPECT_EQ(target.value().parameter("y"), "&");
  EXPECT_EQ(target.value().parameter("z"), std::nullopt);
  EXPECT_TRUE(parse_target("/").value().segments.empty());
}

TEST(Target, RefusesWhatTwoProgramsCouldReadDifferently) {
  for (const char* text : {"",
                           "v1",
                           "*",
                           "http://127.0.0.1/v1",
                           "//v1",
                           "/v1/",
                           "/a//b",
                           "/..",
                           "/a/../b",
                           "/a/./b",
                           "/%2e%2e/b",
                           "/.%2E/b",
                           "/a%2fb",
                           "/a%2Fb",
                           "/a%5cb",
                           "/a\\b",
                           "/a%00b",
                           "/a%0ab",
                           "/a%7f",
                           "/a%252e",
                           "/%252e%252e",
                           "/a%",
                           "/a%2",
                           "/a%zz",
                           "/a%ff",
                           "/a%c0%ae",
                           "/a#b",
                           "/a?x=%00",
                           "/a?x=1&x=2",
                           "/a?%zz"})
    EXPECT_FALSE(parse_target(text)) << text;
}

TEST(Target, OfRandomBytesIsRefusedOrHarmless) {
  std::mt19937 random(7);
  const std::string alphabet = "/.%2eEfF05cC\\?&=+ab\xff";
  int taken = 0;
  for (int round = 0; round < 100'000; ++round) {
    std::string text = "/";
    for (std::size_t length = random() % 12; length > 0; --length) text += alphabet[random() % alphabet.size()];
    const auto target = parse_target(text);
    if (!target) continue;
    ++taken;
    for (const std::string& segment : target.value().segments) {
      EXPECT_TRUE(!segment.empty() && segment != "." && segment != "..") << text;
      EXPECT_EQ(segment.find_first_of("/\\"), std::string::npos) << text;
    }
  }
  EXPECT_GT(taken, 1000);
}

TEST(Target, SegmentsAreReadBackAsTheyWereEncoded) {
  for (const std::string name : {"a b", "\xc3\xa9", "a&b=c?d#e", "x:y", "~-._"})
    EXPECT_EQ(parse_target("/" + encode_segment(name)).value().segments, std::vector<std::string>{name});
}

// What RFC 3986, 5.2.4 makes of a reference at a page, for paths.
std::string resolved(const std::string& from, std::string reference) {
  std::vector<std::string> parts;
  const auto push = [&](const std::string& path) {
    parts.clear();
    for (std::size_t at = 1, end = 0; at <= path.size(); at = end + 1) {
      end = std::min(path.find('/', at), path.size());
      const std::string part = path.substr(at, end - at);
      if (part == "..") {
        if (!parts.empty()) parts.pop_back();
        if (end == path.size()) parts.emplace_back();
      } else if (part == ".") {
        if (end == path.size()) parts.emplace_back();
      } else {
        parts.push_back(part);
      }
    }
  };
  push(from.substr(0, from.rfind('/') + 1) + reference);
  std::string path;
  for (const std::string& part : parts) path += "/" + part;
  return path;
}

TEST(RelativeReference, LeadsThere) {
  const std::vector<std::string> paths{"/",
                                       "/v1",
                                       "/v1/jobs",
                                       "/v1/jobs/j1",
                                       "/v1/jobs/j1/results",
                                       "/v1/jobs/a:b",
                                       "/v1/processes/info/execution",
                                       "/v1/triangulations/block/files/deep/a"};
  for (const std::string& from : paths)
    for (const std::string& to : paths) EXPECT_EQ(resolved(from, relative_reference(from, to)), to) << from;
}

}  // namespace
}  // namespace tessera::service::http
