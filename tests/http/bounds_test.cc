// What keeps strangers from taking connections and filling the log.
#include <gtest/gtest.h>

#include <boost/asio/ip/address.hpp>
#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "src/service/http/connection_counts.h"
#include "src/service/http/refusal_log.h"

namespace tessera::service::http {
namespace {

TEST(ConnectionCounts, AreOfAllAndOfAnAddress) {
  ConnectionCounts counts(20);
  for (int at = 0; at < 10; ++at) EXPECT_TRUE(counts.take("a"));
  EXPECT_FALSE(counts.take("a")) << "half of them";
  for (int at = 0; at < 9; ++at) EXPECT_TRUE(counts.take("b"));
  EXPECT_TRUE(counts.take("c"));
  EXPECT_FALSE(counts.take("d")) << "twenty";
  counts.give_back("c");
  EXPECT_FALSE(counts.take("a"));
  EXPECT_TRUE(counts.take("b"));
  ConnectionCounts few(4);
  for (int at = 0; at < 4; ++at) EXPECT_TRUE(few.take("a")) << "who is alone has them all";
  EXPECT_FALSE(few.take("a"));
}

TEST(ConnectionCounts, OneUserIsOneAddress) {
  const auto group = [](const char* text) { return group_of(boost::asio::ip::make_address(text)); };
  EXPECT_EQ(group("10.1.2.3"), "10.1.2.3");
  EXPECT_NE(group("10.1.2.3"), group("10.1.2.4"));
  EXPECT_EQ(group("::ffff:10.1.2.3"), group("10.1.2.3")) << "a listener of both kinds";
  EXPECT_EQ(group("2001:db8:1:2::1"), group("2001:db8:1:2:ffff:ffff:ffff:ffff"));
  EXPECT_NE(group("2001:db8:1:2::1"), group("2001:db8:1:3::1"));
}

TEST(ConnectionCounts, LeaveDescriptorsToJobs) {
  for (const std::uint64_t limit : {64, 256, 1024, 4096}) EXPECT_LE(connections_within(limit, 4096) * 2, limit / 2);
  EXPECT_EQ(connections_within(65'536, 4096), 4096U);
  EXPECT_EQ(connections_within(0, 4096), 8U) << "an API that answers nobody would be none";
}

class Refusals : public testing::Test {
 protected:
  void refused(const std::string& address, int ms) { log_.refused(address, "no", at(ms)); }
  static RefusalLog::Clock::time_point at(int ms) {
    return RefusalLog::Clock::time_point() + std::chrono::hours(1) + std::chrono::milliseconds(ms);
  }
  std::vector<std::string> lines_;
  RefusalLog log_{[this](const std::string& line) { lines_.push_back(line); }};
};

TEST_F(Refusals, AreALineASecondOfAnAddressAndACount) {
  for (int ms = 0; ms < 1000; ++ms) refused("a", ms);
  EXPECT_EQ(lines_, std::vector<std::string>{"no"});
  refused("b", 500);
  EXPECT_EQ(lines_.size(), 2U);
  refused("a", 1000);
  EXPECT_EQ(lines_.back(), "no; and 999 more refusals before it");
  refused("a", 1001);
  log_.tell(at(1500));
  EXPECT_EQ(lines_.size(), 3U);
  log_.tell(at(2000));
  EXPECT_EQ(lines_.back(), "audit: a: and 1 more refusal");
  log_.tell(at(9000));
  EXPECT_EQ(lines_.size(), 4U) << "of each it is told once";
}

TEST_F(Refusals, OfManyAddressesAreBoundedToo) {
  for (int number = 0; number < 1000; ++number) refused("a" + std::to_string(number), 0);
  EXPECT_EQ(lines_.size(), RefusalLog::callers_max);
  log_.tell(at(1000));
  EXPECT_EQ(lines_.size(), RefusalLog::callers_max + 1);
  EXPECT_EQ(lines_.back(), "audit: others: and 936 more refusals");
  refused("b", 1001);
  EXPECT_EQ(lines_.back(), "no");
}

}  // namespace
}  // namespace tessera::service::http
