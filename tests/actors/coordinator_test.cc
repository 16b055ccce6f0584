// A coordinator and nodes that come, are lost, and answer at moments that the harness hardly ever finds. The test is
// each of the nodes, and its part.
#include "actors/coordinator.h"

#include <gtest/gtest.h>

#include <caf/all.hpp>
#include <caf/scheduler/test_coordinator.hpp>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "actors/run_owner.h"
#include "tests/actors/stepped_config.h"

namespace tessera {
namespace {

class Owner final : public RunOwner {
 public:
  void progressed(const RunProgress&) override {}
  void stored(const TileDone&) override {}
  void said(const std::string&) override {}
  void ended(RunEnded) noexcept override {}
};

constexpr std::uint32_t tiles = 6;

// Of one point each.
CoordinatorOptions job() {
  CoordinatorOptions made;
  for (std::uint32_t t = 0; t < tiles; ++t) made.order.push_back(TileId{t});
  made.points.assign(tiles, 1);
  made.spec.grace_s = 3600;
  made.mark_settled = [](bool) { return success(); };
  made.is_settled = [] { return Result<bool>(false); };
  return made;
}

CoordinatorOptions begun_with(Table table) {
  CoordinatorOptions first = job();
  first.spec.table = std::move(table);
  return first;
}

CoordinatorOptions taken_over() {
  CoordinatorOptions second = job();
  second.term = 1;
  second.take_over = true;
  return second;
}

Table table_of(const std::vector<std::uint32_t>& nodes) {
  Table table{0, {}, std::vector<std::uint32_t>(nodes.size())};
  for (const std::uint32_t node : nodes) table.nodes.push_back(NodeId{node});
  return table;
}

class Nodes : public ::testing::Test {
 protected:
  // What a node, or its part, has heard since it listened last.
  struct Heard {
    std::optional<OpenPart> open;
    std::optional<Table> table;
    int releases = 0;
  };

  ~Nodes() override {
    caf::anon_send_exit(coordinator_, caf::exit_reason::kill);
    run();
  }

  static caf::actor handle_of(const caf::scoped_actor& actor) { return caf::actor_cast<caf::actor>(actor.ptr()); }
  void run() { scheduler_.run(); }

  void start(CoordinatorOptions options, const std::vector<const caf::scoped_actor*>& nodes) {
    std::vector<NodeHandle> handles;
    for (const auto* node : nodes) handles.push_back(caf::actor_cast<NodeHandle>(handle_of(*node)));
    coordinator_ = system_.spawn<Coordinator>(std::move(options), owner_, std::move(handles));
    run();
  }
  template <class Message>
  void tell(const caf::scoped_actor& from, Message message) {
    from->send(coordinator_, std::move(message));
    run();
  }
  void tell_opened(const caf::scoped_actor& node) {
    const auto open = listen(node).open;
    ASSERT_TRUE(open);
    PartOpened opened;
    opened.node = open->node;
    opened.part = handle_of(node);
    tell(node, std::move(opened));
  }
  void tell_found(const caf::scoped_actor& node, std::uint32_t number, const Table& table) {
    PartFound found;
    found.term = 1;
    found.node = found.part = handle_of(node);
    found.self = NodeId{number};
    found.begun = true;
    found.table = table;
    tell(node, std::move(found));
  }

  Heard listen(const caf::scoped_actor& ear) {
    Heard heard;
    bool more = true;
    ear->receive_while([&] {
      return more;
    })([&](const OpenPart& open) { heard.open = open; }, [&](const ChangeTable& change) { heard.table = change.table; },
       [&](const Release&) { ++heard.releases; }, [](const BeginPart&) {}, [](const FindPart&) {}, [](const Probe&) {},
       caf::after(std::chrono::seconds(0)) >> [&] { more = false; });
    return heard;
  }

  Owner owner_;
  SteppedConfig config_;
  caf::actor_system system_{config_};
  caf::scheduler::test_coordinator& scheduler_ = dynamic_cast<caf::scheduler::test_coordinator&>(system_.scheduler());
  caf::scoped_actor a_{system_}, b_{system_}, c_{system_};
  CoordinatorHandle coordinator_;
};

TEST_F(Nodes, ThatAreAskedTwiceForTilesAnswerTwice) {
  start(begun_with(table_of({0, 0, 0, 0, 0, 0})), {&a_});
  tell_opened(a_);
  for (const caf::scoped_actor* late : {&b_, &c_}) {
    tell(a_, NodeJoined{handle_of(*late)});
    tell_opened(*late);
  }
  EXPECT_EQ(listen(a_).releases, 2);
  EXPECT_EQ(listen(b_).releases, 1);
  tell(a_, PartReleased{NodeId{0}, {}});
  tell(b_, PartReleased{NodeId{1}, {}});
  EXPECT_FALSE(listen(a_).table) << "one answer is still to come";
  tell(a_, PartReleased{NodeId{0}, {TileId{5}}});
  const auto table = listen(a_).table;
  ASSERT_TRUE(table);
  EXPECT_NE(table->node_of(TileId{5}), NodeId{0});
  EXPECT_EQ(table->peer_of(TileId{5}).incarnation, 1u);
  EXPECT_EQ(table->node_of(TileId{4}), NodeId{0});
}

TEST_F(Nodes, ThatAreLostAfterTheyHaveAnsweredHaveNoTilesAnyMore) {
  const Table table = table_of({0, 0, 0, 1, 1, 1});
  start(taken_over(), {&a_, &b_});
  tell_found(b_, 1, table);
  tell(a_, NodeLost{handle_of(b_)});
  tell_found(a_, 0, table);
  const auto next = listen(a_).table;
  ASSERT_TRUE(next);
  for (std::uint32_t t = 0; t < tiles; ++t) {
    EXPECT_EQ(next->node_of(TileId{t}), NodeId{0});
    EXPECT_EQ(next->peer_of(TileId{t}).incarnation > 0, t >= 3) << t;
  }
}

// Their parts may still speak: to whom they have no tiles, too.
TEST_F(Nodes, ThatAreLostAfterTheyHaveAnsweredKeepTheirNumber) {
  const Table table = table_of({0, 0, 0, 0, 0, 0});
  start(taken_over(), {&a_, &b_});
  tell_found(b_, 1, table);
  tell(a_, NodeLost{handle_of(b_)});
  tell_found(a_, 0, table);
  tell(a_, NodeJoined{handle_of(c_)});
  const auto open = listen(c_).open;
  ASSERT_TRUE(open);
  EXPECT_EQ(open->node, NodeId{2});
}

}  // namespace
}  // namespace tessera
