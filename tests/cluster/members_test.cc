// Leases and losses on a clock of the test's.
#include "src/cluster/members.h"

#include <gtest/gtest.h>

#include "src/cluster/cluster_options.h"

namespace tessera {
namespace {

using namespace std::chrono_literals;

Members::Time at(std::chrono::milliseconds time) { return Members::Time{} + time; }

MemberInfo node(const std::string& uuid) { return {uuid, "node-" + uuid, "127.0.0.1:1", 1, 1}; }

std::vector<NodeUuid> uuids(const std::vector<Members::Loss>& losses) {
  std::vector<NodeUuid> out;
  for (const auto& loss : losses) out.push_back(loss.member.info.uuid);
  return out;
}

// Asked every second, as the actor does.
std::vector<NodeUuid> silent_until(Members& members, std::chrono::seconds from, std::chrono::seconds to) {
  std::vector<NodeUuid> lost;
  for (auto now = from; now <= to; now += 1s) {
    for (const NodeUuid& uuid : uuids(members.lose_silent(at(now)))) lost.push_back(uuid);
  }
  return lost;
}

TEST(Members, WhoDoesNotRenewItsLeaseIsLostAndDoesNotComeBack) {
  Members members(10s);
  EXPECT_TRUE(members.hello(node("a"), {}, at(0s)));
  EXPECT_TRUE(members.hello(node("b"), {}, at(0s)));
  EXPECT_TRUE(members.renew("b", {5, 7}, at(9s)));
  EXPECT_EQ(silent_until(members, 0s, 10s), std::vector<NodeUuid>{});
  EXPECT_EQ(silent_until(members, 11s, 19s), std::vector<NodeUuid>{"a"});
  EXPECT_FALSE(members.hello(node("a"), {}, at(20s)));
  EXPECT_FALSE(members.renew("a", {}, at(20s)));
  EXPECT_EQ(members.all().size(), 1U);
  EXPECT_EQ(members.find("b")->use.memory_bytes, 5U);
  EXPECT_EQ(members.find("b")->use.scratch_free_bytes, 7U);
}

// A coordinator that was stopped, or had no processor, has heard nothing because it did not listen.
TEST(Members, LeasesGoOnForAsLongAsNobodyListened) {
  Members members(10s);
  members.hello(node("a"), {}, at(0s));
  EXPECT_TRUE(members.lose_silent(at(1s)).empty());
  EXPECT_TRUE(members.lose_silent(at(60s)).empty());
  EXPECT_EQ(silent_until(members, 61s, 80s), std::vector<NodeUuid>{"a"});
}

TEST(Members, OfThoseWhoCannotReachEachOtherTheWorstConnectedIsLost) {
  Members members(8s);
  for (const char* uuid : {"a", "b", "c", "d"}) members.hello(node(uuid), {}, at(0s));
  members.note_unreachable("b", "a", at(0s));
  EXPECT_TRUE(members.lose_silent(at(500ms)).empty());  // others may say the same
  members.note_unreachable("a", "c", at(600ms));
  members.note_unreachable("d", "a", at(700ms));
  EXPECT_EQ(uuids(members.lose_silent(at(1s))), std::vector<NodeUuid>{"a"});
  members.note_unreachable("b", "a", at(2s));  // said before it was known to be lost
  EXPECT_TRUE(members.lose_silent(at(3s)).empty());
  members.note_unreachable("b", "c", at(3s));
  EXPECT_EQ(uuids(members.lose_silent(at(4s))), std::vector<NodeUuid>{"c"});  // of equal ones the last that came
}

TEST(Members, ANodeIsFreeOnceItHasReachedTheOthers) {
  Members members(10s);
  members.hello(node("a"), {}, at(0s));
  EXPECT_FALSE(members.find("a")->free);
  EXPECT_TRUE(members.mark_reached_all("a"));
  EXPECT_FALSE(members.mark_reached_all("a"));
  EXPECT_FALSE(members.mark_reached_all("nobody"));
  EXPECT_TRUE(members.find("a")->free);
}

// One of the two is lost soon; whoever stays says again that it has reached all.
TEST(Members, ANodeIsNotFreeWhileAnotherMemberCannotBeReached) {
  Members members(8s);
  for (const char* uuid : {"a", "b", "c"}) members.hello(node(uuid), {}, at(0s));
  members.note_unreachable("a", "c", at(0s));
  EXPECT_FALSE(members.mark_reached_all("a"));
  EXPECT_FALSE(members.find("a")->free);
  EXPECT_TRUE(members.mark_reached_all("b"));
  EXPECT_EQ(uuids(members.lose_silent(at(1s))), std::vector<NodeUuid>{"c"});
  EXPECT_TRUE(members.mark_reached_all("a"));
  members.note_unreachable("b", "c", at(2s));   // which is no member any more
  EXPECT_FALSE(members.mark_reached_all("b"));  // as it has been
  EXPECT_TRUE(members.find("b")->free);
}

TEST(Addresses, AreAllOfAName) {
  EXPECT_EQ(addresses_of({"127.0.0.1", 7}).value(), (std::vector<HostPort>{{"127.0.0.1", 7}}));
  EXPECT_EQ(addresses_of({"::1", 7}).value(), (std::vector<HostPort>{{"::1", 7}}));
  const auto local = addresses_of({"localhost", 7}).value();
  for (const HostPort& address : local)
    EXPECT_TRUE(address.host == "127.0.0.1" || address.host == "::1") << address.host;
}

}  // namespace
}  // namespace tessera
