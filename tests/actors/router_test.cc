// Every stretch is routed once, whoever is lost, comes late, or cannot read it.
#include "actors/router.h"

#include <gtest/gtest.h>

#include <atomic>
#include <caf/all.hpp>
#include <future>
#include <mutex>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace tessera {
namespace {

class Config : public caf::actor_system_config {
 public:
  Config() { add_message_types<caf::id_block::tessera>(); }
};

class Owner final : public RoutingOwner {
 public:
  struct Here {
    std::uint32_t split = 0, attempt = 0;
    std::string why;
  };
  void progressed(std::uint64_t points) override { points_ = points; }
  void route_here(std::uint32_t split, std::uint32_t attempt, std::string why) override {
    here_.set_value({split, attempt, std::move(why)});
  }
  void ended(std::vector<std::uint32_t> attempts, Failure failure) noexcept override {
    end_.set_value({std::move(attempts), std::move(failure)});
  }
  Here next() {
    auto next = here_.get_future().get();
    return next;
  }
  void again() { here_ = {}; }
  std::pair<std::vector<std::uint32_t>, Failure> end() { return end_.get_future().get(); }
  std::atomic<std::uint64_t> points_{0};

 private:
  std::promise<Here> here_;
  std::promise<std::pair<std::vector<std::uint32_t>, Failure>> end_;
};

class RouterTest : public ::testing::Test {
 protected:
  using Node = caf::scoped_actor;
  static NodeHandle handle(Node& node) { return caf::actor_cast<NodeHandle>(node.ptr()); }
  void start(std::size_t splits, std::vector<Node*> nodes, std::vector<bool> here = {}) {
    here.resize(splits);
    std::vector<NodeHandle> handles;
    for (Node* node : nodes) handles.push_back(handle(*node));
    router_ = system_.spawn<Router>(RouterOptions{"run", 2, std::move(here)}, owner_, handles);
  }
  static RouteSplit order(Node& node) {
    RouteSplit wanted;
    node->receive([&](RouteSplit& got) { wanted = std::move(got); });
    EXPECT_EQ(wanted.run_folder, "run");
    EXPECT_EQ(wanted.shares, 2u);
    return wanted;
  }
  void say(std::uint32_t attempt, std::uint64_t points, bool done = true, Failure failure = {}) {
    caf::anon_send(router_, SplitRouted{attempt, points, done, std::move(failure)});
  }

  Config config_;
  caf::actor_system system_{config_};
  Owner owner_;
  RouterHandle router_;
};

TEST_F(RouterTest, GivesEachNodeOneAtATime) {
  Node a{system_}, b{system_};
  start(3, {&a, &b});
  const auto first = order(a), second = order(b);
  EXPECT_EQ(first.split, 0u);
  EXPECT_EQ(second.split, 1u);
  say(second.attempt, 5);
  const auto third = order(b);
  EXPECT_EQ(third.split, 2u);
  say(third.attempt, 7);
  say(first.attempt, 1, false);
  say(first.attempt, 11);
  const auto [attempts, failure] = owner_.end();
  EXPECT_FALSE(failure);
  EXPECT_EQ(attempts, (std::vector<std::uint32_t>{first.attempt, second.attempt, third.attempt}));
}

TEST_F(RouterTest, GivesTheStretchOfALostNodeToAnotherAndForgetsWhatItSays) {
  Node a{system_};
  RouteSplit lost, also_lost;
  {
    Node b{system_};
    start(3, {&a, &b});
    const auto first = order(a);
    lost = order(b);
    say(first.attempt, 1);
    also_lost = order(a);
    caf::anon_send(router_, NodeLost{caf::actor_cast<caf::actor>(a.ptr())});
  }  // b is gone without a word
  // Nobody is left: what waits goes to the owner, until somebody comes.
  const auto here = owner_.next();
  owner_.again();
  EXPECT_EQ(here.why, "");
  Node c{system_};
  caf::anon_send(router_, NodeJoined{caf::actor_cast<caf::actor>(c.ptr())});
  const auto last = order(c);
  EXPECT_EQ((std::set<std::uint32_t>{here.split, last.split}), (std::set<std::uint32_t>{1, 2}));
  say(lost.attempt, 100);
  say(also_lost.attempt, 100);
  say(here.attempt, 1);
  say(last.attempt, 1);
  const auto [attempts, failure] = owner_.end();
  EXPECT_FALSE(failure);
  EXPECT_EQ(attempts[here.split], here.attempt);
  EXPECT_EQ(attempts[last.split], last.attempt);
  EXPECT_LE(owner_.points_, 3u);
}

TEST_F(RouterTest, HasTheOwnerRouteWhatANodeCannotAndWhatOnlyItCan) {
  Node a{system_};
  start(3, {&a}, {false, true, false});
  const auto own = owner_.next();
  owner_.again();
  EXPECT_EQ(own.split, 1u);
  const auto cannot = order(a);
  say(cannot.attempt, 0, true, failure_of(error(Errc::io, "x.laz: no such file")));
  say(own.attempt, 1);
  auto here = owner_.next();
  owner_.again();
  EXPECT_EQ(here.split, 0u);
  EXPECT_EQ(here.why, "x.laz: no such file");
  say(here.attempt, 1);
  here = owner_.next();  // the node gets no more
  EXPECT_EQ(here.split, 2u);
  say(here.attempt, 0, true, failure_of(error(Errc::bad_input, "y.laz: is damaged")));
  const auto [attempts, failure] = owner_.end();
  EXPECT_EQ(failure.text, "y.laz: is damaged");
}

TEST_F(RouterTest, EndsWhenItIsCancelled) {
  Node a{system_};
  start(1, {&a});
  a->monitor(router_);
  order(a);
  caf::anon_send(router_, Cancel{});
  EXPECT_EQ(owner_.end().second.code, static_cast<std::uint8_t>(Errc::interrupted));
  a->receive([](const caf::down_msg&) {});  // so that the node stops, too
}

}  // namespace
}  // namespace tessera
