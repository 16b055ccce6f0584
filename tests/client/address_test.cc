#include "src/service/client/address.h"

#include <gtest/gtest.h>

namespace tessera::client {
namespace {

ServerAddress parsed(std::string_view text) {
  const auto address = parse_address(text);
  EXPECT_TRUE(address) << text;
  return address ? address.value() : ServerAddress{};
}

TEST(ServerAddress, IsReadAsItIsWritten) {
  EXPECT_EQ(parsed("http://127.0.0.1:7070"), (ServerAddress{false, "127.0.0.1", "7070", "", ""}));
  EXPECT_EQ(parsed("https://host.example/"), (ServerAddress{true, "host.example", "443", "", ""}));
  EXPECT_EQ(parsed("http://[::1]:80/tessera/"), (ServerAddress{false, "::1", "80", "/tessera", ""}));
  EXPECT_EQ(parsed("http://localhost:7070/#token=a-b_c"), (ServerAddress{false, "localhost", "7070", "", "a-b_c"}));
  EXPECT_EQ(parsed("http://localhost:7070/?token=a-b_c"), (ServerAddress{false, "localhost", "7070", "", "a-b_c"}));
}

TEST(ServerAddress, IsShownWithoutItsToken) {
  EXPECT_EQ(parsed("http://localhost:7070/?token=secret").text(), "http://localhost:7070");
  EXPECT_EQ(parsed("https://[::1]/x/").text(), "https://[::1]/x");
  EXPECT_EQ(parsed("http://[::1]:7070").authority(), "[::1]:7070");
}

TEST(ServerAddress, RefusesWhatIsNone) {
  for (const auto* text : {"", "localhost:7070", "ftp://a", "http://", "http://:80", "http://a:0", "http://a:65536",
                           "http://a:x", "http://a:", "http://::1:80", "http://[::1", "http://[::1]x", "http://u:p@a",
                           "http://a b", "http://a/?x=1", "http://a/#x", "http://a\r\nX: y/", "http://a/\x01"})
    EXPECT_FALSE(parse_address(text)) << text;
  const auto refused = parse_address("htp://host/?token=secret");
  EXPECT_EQ(refused.error().where.find("secret"), std::string::npos);
}

TEST(PercentEncoded, LeavesWhatStandsForItself) {
  EXPECT_EQ(percent_encoded("aZ09-._~"), "aZ09-._~");
  EXPECT_EQ(percent_encoded("a/b c?d%\xc3\xa9"), "a%2Fb%20c%3Fd%25%C3%A9");
}

TEST(FollowLink, LeadsFromTheAnswersOwnAddress) {
  const auto server = parsed("http://host:7070/base");
  const auto to = [&](std::string_view href) { return follow_link(server, "/base/v1/jobs?limit=2", href).value(); };
  EXPECT_EQ(to("?limit=2&after=x"), "/base/v1/jobs?limit=2&after=x");
  EXPECT_EQ(to("jobs?after=x"), "/base/v1/jobs?after=x");
  EXPECT_EQ(to("./jobs/a"), "/base/v1/jobs/a");
  EXPECT_EQ(to("../v1/a/./b/../c"), "/base/v1/a/c");
  EXPECT_EQ(to("/v1/x/.."), "/v1/");
  EXPECT_EQ(to("http://host:7070/v1/y?z=http://q"), "/v1/y?z=http://q");
  EXPECT_EQ(to("x?a=../b"), "/base/v1/x?a=../b");
}

TEST(FollowLink, DoesNotLeaveTheServer) {
  const auto server = parsed("http://host:7070");
  for (const auto* href : {"http://other:7070/v1", "https://host:7070/v1", "http://host/v1", "//other/v1",
                           "ftp://host/", "http://host:7070@other/"})
    EXPECT_FALSE(follow_link(server, "/v1/jobs", href)) << href;
}

}  // namespace
}  // namespace tessera::client
