// One share among messages in orders that a network can make, and the harness hardly or never: its coordinator tells
// all shares at once. The test is the coordinator, and the other node.
#include "actors/share_actor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <caf/all.hpp>
#include <caf/scheduler/test_coordinator.hpp>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "actors/harness/memory_storage.h"
#include "actors/harness/setting.h"
#include "actors/node_actor.h"
#include "tests/actors/stepped_config.h"

namespace tessera {
namespace {

class Processed final : public ExchangeWatch {
 public:
  void sent(TileIncarnation, TileIncarnation, Totals) override {}
  void processed(TileIncarnation from, TileIncarnation, Totals) override { ++from_[from]; }
  void rejoined(TileIncarnation, Totals) override {}
  std::uint64_t from(TileIncarnation peer) { return from_[peer]; }

 private:
  std::map<TileIncarnation, std::uint64_t> from_;
};

constexpr NodeId here{0}, there{1};
constexpr std::uint32_t tiles = 6;
constexpr TileId foreign{5};  // the others are here

Setting setting() {
  HarnessOptions how;
  how.dimension = 2;
  how.points = 60;
  how.tiles = tiles;
  how.nodes = 2;
  how.mail_bytes_max = 0;
  std::mt19937_64 random(7);
  Setting made = make_setting(how, 7, random);
  made.late_stores = false;
  made.outboxes = {};
  made.schedule.threads = 1;
  made.schedule.memory_bytes = std::uint64_t{1} << 40;
  RoutingTable table{{}, 0, std::vector<NodeId>(tiles, here), std::vector<Incarnation>(tiles)};
  table.nodes[foreign.value] = there;
  made.table = std::make_shared<const RoutingTable>(table);
  made.spec.table = std::move(table);
  return made;
}

class OneShare : public ::testing::Test {
 protected:
  // What the test has heard since it listened last.
  struct Heard {
    std::vector<ShareTally> tallies;
    std::vector<ShareReleased> released;
    std::vector<ShareFound> found;
    std::vector<std::string> ended;  // why
    int idle = 0;
  };

  OneShare() {
    NodeOptions node;
    node.memory_bytes = ~std::uint64_t{0};
    node_ = system_.spawn<NodeActor>(
        std::move(node),
        std::make_shared<MemoryShares>(setting_, storage_, std::vector<ExchangeWatch*>{&watch_}, here));
    self_->send(node_, OpenShare{JobId{1}, here, to_bytes(setting_.spec), handle_of(self_), {}});
    run();
    self_->receive([&](const ShareOpened& opened) { share_ = caf::actor_cast<ShareHandle>(opened.share); });
  }
  ~OneShare() override {
    caf::anon_send_exit(share_, caf::exit_reason::kill);
    caf::anon_send_exit(node_, caf::exit_reason::kill);
    run();
  }

  static caf::actor handle_of(const caf::scoped_actor& actor) { return caf::actor_cast<caf::actor>(actor.ptr()); }
  std::vector<caf::actor> shares() const { return {caf::actor_cast<caf::actor>(share_), handle_of(self_)}; }

  template <class Message>
  void tell(Message message) {
    self_->send(share_, std::move(message));
  }
  void begin() { tell(BeginShare{shares(), {}, false}); }
  // The other node's tile was reborn, so often.
  void change_table(std::uint32_t incarnation) {
    RoutingTable table = *setting_.table;
    table.epoch = {{}, incarnation};
    table.incarnations[foreign.value] = {{}, incarnation};
    tell(ChangeTable{std::move(table), shares(), false});
  }
  void mail(TileIncarnation from, std::uint32_t epoch) {
    tell(Packet{there, std::uint64_t{1} << 20, {Update{from, {TileId{0}, {}}, {{}, epoch}, 1, {}}}});
  }

  // Each actor in its turn, a message at a time, until all is done.
  void run() { scheduler_.run(); }
  void run_share() {
    auto* const share = dynamic_cast<caf::resumable*>(caf::actor_cast<caf::abstract_actor*>(share_));
    scheduler_.run_jobs_filtered([&](caf::resumable* job) { return job == share; });
  }
  // One message of an actor that is ready.
  void step(caf::resumable* actor) {
    auto& jobs = scheduler_.jobs;
    const auto found = std::find(jobs.begin(), jobs.end(), actor);
    ASSERT_NE(found, jobs.end());
    std::rotate(jobs.begin(), found, found + 1);
    scheduler_.run_once();
  }

  Heard listen(const caf::scoped_actor& ear) {
    Heard heard;
    bool more = true;
    ear->receive_while([&] { return more; })([&](const ShareTally& tally) { heard.tallies.push_back(tally); },
                                             [&](const ShareReleased& released) { heard.released.push_back(released); },
                                             [&](const ShareFound& found) { heard.found.push_back(found); },
                                             [&](const ShareIdle&) { ++heard.idle; }, [](const ShareBegun&) {},
                                             [&](const ShareEnded& end) { heard.ended.push_back(end.failure.text); },
                                             [](const ShareProgress&) {}, [](const Packet&) {}, [](const Credit&) {},
                                             caf::after(std::chrono::seconds(0)) >> [&] { more = false; });
    return heard;
  }
  Heard listen() { return listen(self_); }

  const Setting setting_ = setting();
  MemoryStorage storage_{2, setting_.tiles};
  Processed watch_;
  SteppedConfig config_;
  caf::actor_system system_{config_};
  caf::scheduler::test_coordinator& scheduler_ = dynamic_cast<caf::scheduler::test_coordinator&>(system_.scheduler());
  caf::scoped_actor self_{system_};
  NodeHandle node_;
  ShareHandle share_;
};

TEST_F(OneShare, KeepsMailThatComesBeforeItIsToldToBegin) {
  mail({foreign, {}}, 0);
  run();
  EXPECT_EQ(watch_.from({foreign, {{}, 0}}), 0u);
  begin();
  run();
  EXPECT_EQ(watch_.from({foreign, {{}, 0}}), 1u);
}

TEST_F(OneShare, KeepsMailOfAnEpochWhoseTableIsStillToCome) {
  begin();
  run();
  mail({foreign, {{}, 1}}, 1);
  run();
  EXPECT_EQ(watch_.from({foreign, {{}, 1}}), 0u);
  change_table(1);
  run();
  EXPECT_EQ(watch_.from({foreign, {{}, 1}}), 1u);
}

TEST_F(OneShare, IsBusyUntilAllItsTilesGoByTheTable) {
  begin();
  run();
  EXPECT_EQ(listen().idle, 1);
  tell(Probe{Wave{1}});
  run();
  ASSERT_TRUE(listen().tallies.at(0).idle);
  change_table(1);
  tell(Probe{Wave{2}});  // heard before any tile hears of the table
  run();
  const Heard heard = listen();
  ASSERT_EQ(heard.tallies.size(), 1u);
  EXPECT_EQ(heard.tallies[0].epoch, (Epoch{{}, 1}));
  EXPECT_FALSE(heard.tallies[0].idle);
  EXPECT_EQ(heard.idle, 1);
  tell(Probe{Wave{3}});
  run();
  EXPECT_TRUE(listen().tallies.at(0).idle);
}

// Of two tables it says twice that it goes by the second; meanwhile it may have been given up.
TEST_F(OneShare, DoesNotWaitForATileThatItHasGivenUp) {
  begin();
  run_share();  // tiles 0 and 1 are to begin
  change_table(1);
  change_table(2);
  run_share();
  const std::vector<caf::resumable*> actors(scheduler_.jobs.begin(), scheduler_.jobs.end());
  ASSERT_EQ(actors.size(), tiles - 1);
  for (const std::size_t t : {4, 3, 2, 1, 0}) step(actors[t]);
  for (const std::size_t t : {1, 0}) step(actors[t]);  // these had to begin first
  tell(Release{1});
  run_share();
  run();
  const Heard heard = listen();
  ASSERT_EQ(heard.released.size(), 1u);
  EXPECT_EQ(heard.released[0].tiles, std::vector<TileId>{TileId{4}});
  EXPECT_EQ(heard.idle, 1);
}

// Its disk is full, say, at the moment at which another node is lost.
TEST_F(OneShare, EndsWhenATileEndsThatWasToGoByTheTable) {
  begin();
  run();
  storage_.fault = StorageFault{StorageFault::Call::append, StorageFault::How::exception, 0};
  tell(Packet{
      there, std::uint64_t{1} << 20, {Update{{foreign, {}}, {TileId{0}, {}}, {{}, 0}, 1, BigVector<std::byte>(120)}}});
  change_table(1);
  run_share();  // so that the tile finds both in its mailbox
  EXPECT_TRUE(listen().ended.empty());
  run();
  const auto ended = listen().ended;
  ASSERT_EQ(ended.size(), 1u);
  EXPECT_NE(ended[0].find("the harness's storage throws"), std::string::npos) << ended[0];
}

// The one before it may not have heard, or not written down, that these are nobody's.
TEST_F(OneShare, TellsWhoeverTakesOverWhichTilesItHasGivenUp) {
  begin();
  run_share();
  tell(Release{1});
  run();
  ASSERT_EQ(listen().released.size(), 1u);
  const caf::scoped_actor next(system_);
  next->send(node_, FindShare{JobId{1}, 1, caf::actor_cast<caf::actor>(node_), handle_of(next)});
  run();
  const Heard heard = listen(next);
  ASSERT_EQ(heard.found.size(), 1u);
  EXPECT_EQ(heard.found[0].released, std::vector<TileId>{TileId{4}});
}

// By whoever has a certificate: neither ends the process.
TEST_F(OneShare, BeginsOnceHoweverOftenItIsToldTo) {
  begin();
  run();
  begin();
  run();
  EXPECT_EQ(listen().idle, 1);
}

// By whoever keeps to no window.
TEST_F(OneShare, EndsWhenMailOfTablesThatNeverComeIsMoreThanNodesSend) {
  begin();
  run();
  const Update update{{foreign, {{}, 1}}, {TileId{0}, {}}, {{}, 1}, 1, BigVector<std::byte>(message_bytes_max)};
  const std::uint64_t most = 16 * in_flight_max;
  for (std::uint64_t sent = 0; sent <= most; sent += Outbox::bytes_of(update)) {
    EXPECT_TRUE(sent + Outbox::bytes_of(update) > most || listen().ended.empty());
    tell(Packet{there, std::uint64_t{1} << 20, {update}});
    run();
  }
  const auto ended = listen().ended;
  ASSERT_EQ(ended.size(), 1u);
  EXPECT_NE(ended[0].find("bytes of mail for routing tables that it does not have yet"), std::string::npos) << ended[0];
}

TEST_F(OneShare, EndsWhenMailIsOfANodeThatNoJobHas) {
  begin();
  tell(Packet{NodeId{1 << 16}, std::uint64_t{1} << 20, {}});
  run();
  const auto ended = listen().ended;
  ASSERT_EQ(ended.size(), 1u);
  EXPECT_NE(ended[0].find("received mail from node 65536, but no job has a node of this number"), std::string::npos)
      << ended[0];
}

TEST_F(OneShare, EndsWhenItsTableIsOfAnotherJob) {
  tell(BeginShare{shares(), RoutingTable{{}, 0, {NodeId{0}}, {Incarnation()}}, false});
  run();
  const auto ended = listen().ended;
  ASSERT_EQ(ended.size(), 1u);
  EXPECT_NE(ended[0].find("received a routing table that does not fit its job"), std::string::npos) << ended[0];
}

}  // namespace
}  // namespace tessera
