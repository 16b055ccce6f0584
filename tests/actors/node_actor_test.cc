#include "actors/node_actor.h"

#include <gtest/gtest.h>

#include <caf/all.hpp>
#include <future>
#include <string>
#include <utility>

#include "src/delaunay/delaunay_program.h"

namespace tessera {
namespace {

class Config : public caf::actor_system_config {
 public:
  Config() { add_message_types<caf::id_block::tessera>(); }
};

// Parts whose tiles find no points, once they may look.
class NoPoints final : public ShareSource, public TileStorage, public DelaunayStore {
 public:
  explicit NoPoints(std::size_t tiles) : tiles_(tiles) {}
  Result<std::unique_ptr<Share>> open(const ShareSpec&, NodeId) override {
    auto share = std::make_unique<Share>();
    share->weights = std::make_shared<const std::vector<std::uint64_t>>(tiles_, 1);
    ShareStage& only = share->stages.emplace_back();
    only.schedule.threads = static_cast<std::uint32_t>(tiles_);
    auto stage = std::make_shared<DelaunayStage>();
    stage->storage = only.context.storage = this;
    stage->store = this;
    only.context.programs = std::move(stage);
    return share;
  }

  Result<LoadedTile> load_points(TileId) override {
    looking_.wait();
    return error(Errc::io, "no points");
  }
  Status write(TileId, ScratchKind, std::span<const std::byte>) override { return success(); }
  Status append(TileId, ScratchKind, std::span<const std::byte>) override { return success(); }
  Result<Pieces> read(TileId, ScratchKind) override { return Pieces{}; }
  Result<bool> has(TileId, ScratchKind) override { return false; }
  Status remove(TileId, ScratchKind) override { return success(); }
  Status clear(ScratchKind) override { return success(); }
  std::future<StoredEarly> store_early(TileId, std::shared_ptr<const EarlyFinals>) override { return {}; }
  Status take_early(TileId, BigVector<std::byte>&) override { return success(); }
  void store(TileId, CollectedTile, Finished::Stored) override {}
  void store_points(TileId, PointsOfTile, Finished::Stored) override {}

  std::promise<void> may_look;

 private:
  std::size_t tiles_;
  std::shared_future<void> looking_ = may_look.get_future().share();
};

class Node : public ::testing::Test {
 protected:
  // What the node answers when it is asked for a share that may use so much.
  ShareOpened open(std::uint64_t mebibytes) {
    ShareSpec spec;
    spec.memory_bytes = mebibytes << 20;
    self_->send(node_,
                OpenShare{JobId{++jobs_}, NodeId{0}, to_bytes(spec), caf::actor_cast<caf::actor>(self_.ptr()), {}});
    ShareOpened answer;
    self_->receive([&](ShareOpened& opened) { answer = std::move(opened); });
    return answer;
  }

  template <class... Messages>
  void tell(const ShareOpened& opened, Messages... messages) {
    (self_->send(caf::actor_cast<ShareHandle>(opened.share), std::move(messages)), ...);
  }

  // What a share says at last, once it is gone.
  ShareEnded end_of(const ShareOpened& opened) {
    self_->monitor(opened.share);
    ShareEnded last;
    bool gone = false;
    self_->receive_while([&] { return !gone; })([](const ShareProgress&) {},
                                                [&](ShareEnded& ended) { last = std::move(ended); },
                                                [&](const caf::down_msg&) { gone = true; });
    return last;
  }

  void give_up(const ShareOpened& opened) {
    tell(opened, Abort{});
    end_of(opened);
  }

  std::shared_ptr<NoPoints> source_ = std::make_shared<NoPoints>(2);

 private:
  Config config_;
  caf::actor_system system_{config_};
  caf::scoped_actor self_{system_};
  NodeHandle node_ =
      self_->spawn<NodeActor>(NodeOptions{.memory_bytes = std::uint64_t{100} << 20, .hooks = {}}, source_);
  std::uint64_t jobs_ = 0;
};

TEST_F(Node, HasRoomForJobsUntilItsMemoryIsGivenAwayAndAgainWhenOneHasEnded) {
  const ShareOpened first = open(60), second = open(40);
  ASSERT_FALSE(first.failure || second.failure);
  const ShareOpened third = open(50);
  EXPECT_EQ(third.failure.text, "job 3 wants 50 MiB of memory, but the node has 0 MiB left");
  EXPECT_EQ(third.failure.code, static_cast<std::uint8_t>(Errc::memory));
  give_up(second);
  EXPECT_EQ(open(50).failure.text, "job 4 wants 50 MiB of memory, but the node has 40 MiB left");
  give_up(first);
  const ShareOpened whole = open(100);
  EXPECT_EQ(whole.failure.text, "");
  give_up(whole);
}

// Its mail could not be kept while it worked; then its report comes, or its mesh is stored.
TEST_F(Node, HearsOfATileThatWasGivenUpWhileOthersWork) {
  const ShareOpened share = open(1);
  TileReport report;
  report.span.tile = TileId{0};
  tell(share, BeginShare{{share.share}, {}, false},
       TileFailed{TileId{0}, {static_cast<std::uint8_t>(Errc::io), "no room"}}, std::move(report),
       TileStored{TileId{0}, {}, {}});
  source_->may_look.set_value();
  EXPECT_EQ(end_of(share).failure.text, "no room");
}

}  // namespace
}  // namespace tessera
