// A coordinator whose nodes, and their shares, are the test.
#pragma once

#include <gtest/gtest.h>

#include <caf/all.hpp>
#include <caf/scheduler/test_coordinator.hpp>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "actors/coordinator.h"
#include "actors/run_owner.h"
#include "tests/actors/stepped_config.h"

namespace tessera {

class Owner final : public RunOwner {
 public:
  void progressed(const RunProgress&) override {}
  void stored(const TileDone&) override {}
  void said(const std::string& line) override { lines += line + "\n"; }
  void ended(RunEnded run) noexcept override { end = std::move(run); }

  std::string lines;
  std::optional<RunEnded> end;
};

inline constexpr std::uint32_t tiles = 6;

// Of one point each.
inline CoordinatorOptions job() {
  CoordinatorOptions made;
  for (std::uint32_t t = 0; t < tiles; ++t) made.order.push_back(TileId{t});
  made.weights.assign(tiles, 1);
  made.spec.grace_s = 3600;
  made.mark_settled = [](std::uint32_t, bool) { return success(); };
  made.is_settled = [](std::uint32_t) { return Result<bool>(false); };
  return made;
}

inline CoordinatorOptions begun_with(RoutingTable table) {
  CoordinatorOptions first = job();
  first.spec.table = std::move(table);
  return first;
}

inline CoordinatorOptions taken_over() {
  CoordinatorOptions second = job();
  second.term = Term{1};
  second.take_over = true;
  return second;
}

inline RoutingTable table_of(const std::vector<std::uint32_t>& nodes) {
  RoutingTable table{{}, 0, {}, std::vector<Incarnation>(nodes.size())};
  for (const std::uint32_t node : nodes) table.nodes.push_back(NodeId{node});
  return table;
}

class Nodes : public ::testing::Test {
 protected:
  // What a node, or its share, has heard since it listened last.
  struct Heard {
    std::optional<OpenShare> open;
    std::optional<RoutingTable> table, begun;
    int releases = 0, probes = 0;
    bool aborted = false;
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
  void tell_opened(const caf::scoped_actor& node, std::uint64_t memory_bytes = 0, const std::string& name = {}) {
    const auto open = listen(node).open;
    ASSERT_TRUE(open);
    ShareOpened opened;
    opened.node = open->node;
    opened.share = handle_of(node);
    opened.memory_bytes = memory_bytes;
    opened.name = name;
    tell(node, std::move(opened));
  }
  // It has no share.
  void tell_none(const caf::scoped_actor& node, std::uint64_t memory_bytes, const std::string& name) {
    ShareFound none;
    none.term = Term{1};
    none.node = handle_of(node);
    none.memory_bytes = memory_bytes;
    none.name = name;
    tell(node, std::move(none));
  }
  void tell_found(const caf::scoped_actor& node, std::uint32_t number, const RoutingTable& table) {
    ShareFound found;
    found.term = Term{1};
    found.node = found.share = handle_of(node);
    found.self = NodeId{number};
    found.begun = true;
    found.table = table;
    tell(node, std::move(found));
  }

  Heard listen(const caf::scoped_actor& ear) {
    Heard heard;
    bool more = true;
    ear->receive_while([&] { return more; })(
        [&](const OpenShare& open) { heard.open = open; },
        [&](const ChangeTable& change) { heard.table = change.table; }, [&](const Release&) { ++heard.releases; },
        [&](const BeginShare& begin) { heard.begun = begin.table; }, [](const FindShare&) {},
        [&](const Probe&) { ++heard.probes; }, [&](const Abort&) { heard.aborted = true; },
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

}  // namespace tessera
