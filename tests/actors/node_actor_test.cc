#include "actors/node_actor.h"

#include <gtest/gtest.h>

#include <caf/all.hpp>
#include <string>

namespace tessera {
namespace {

class Config : public caf::actor_system_config {
 public:
  Config() { add_message_types<caf::id_block::tessera>(); }
};

// Parts without tiles.
class NoTiles final : public PartSource {
 public:
  Result<std::unique_ptr<Part>> open(const PartSpec&, NodeId) override { return std::make_unique<Part>(); }
};

class Node : public ::testing::Test {
 protected:
  // What the node answers when it is asked for a part that may use so much.
  PartOpened open(std::uint64_t mebibytes) {
    PartSpec spec;
    spec.memory_bytes = mebibytes << 20;
    self_->send(node_, OpenPart{JobId{++jobs_}, NodeId{0}, to_bytes(spec), caf::actor_cast<caf::actor>(self_.ptr())});
    PartOpened answer;
    self_->receive([&](PartOpened& opened) { answer = std::move(opened); });
    return answer;
  }

  void end(const PartOpened& opened) {
    self_->monitor(opened.part);
    self_->send(caf::actor_cast<PartHandle>(opened.part), Abort{});
    bool gone = false;
    self_->receive_while([&] { return !gone; })([](const PartProgress&) {}, [](const PartEnded&) {},
                                                [&](const caf::down_msg&) { gone = true; });
  }

 private:
  Config config_;
  caf::actor_system system_{config_};
  caf::scoped_actor self_{system_};
  NodeHandle node_ = self_->spawn<NodeActor>(NodeOptions{.memory_bytes = std::uint64_t{100} << 20, .hooks = {}},
                                             std::make_shared<NoTiles>());
  std::uint64_t jobs_ = 0;
};

TEST_F(Node, HasRoomForJobsUntilItsMemoryIsGivenAwayAndAgainWhenOneHasEnded) {
  const PartOpened first = open(60), second = open(40);
  ASSERT_FALSE(first.failure || second.failure);
  const PartOpened third = open(50);
  EXPECT_EQ(third.failure.text, "job 3 wants 50 MiB of memory, but the node has 0 MiB left");
  EXPECT_EQ(third.failure.code, static_cast<std::uint8_t>(Errc::memory));
  end(second);
  EXPECT_EQ(open(50).failure.text, "job 4 wants 50 MiB of memory, but the node has 40 MiB left");
  end(first);
  const PartOpened whole = open(100);
  EXPECT_EQ(whole.failure.text, "");
  end(whole);
}

}  // namespace
}  // namespace tessera
