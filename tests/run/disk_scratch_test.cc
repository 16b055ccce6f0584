#include "src/exchange/disk_scratch.h"

#include <gtest/gtest.h>

#include <future>
#include <set>
#include <span>
#include <stop_token>

#include "src/base/files/folder_lock.h"
#include "src/base/files/handed_file.h"
#include "src/base/files/temporary.h"
#include "src/base/stopped.h"
#include "src/delaunay/disk_store.h"
#include "src/delaunay/run/routed_shares.h"
#include "src/delaunay/run/settled_stages.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

class LockedScratch : public ::testing::Test {
 protected:
  LockedScratch() {
    run_->folder = run_folder(out());
    open({.lock_file = lock_.file()});
  }
  void open(StoreOptions options) {
    store_.reset();
    storage_.emplace(DiskScratchOptions{run_->folder, run_->folder, run_->seal, lock_.file(), {}});
    store_.emplace(routed_points(run_), out(), std::move(options), 1, *storage_, nullptr);
  }
  const fs::path& out() const { return folder_.path(); }

  // As another process that found it silent.
  void take_the_lock_away() const { fs::rename(lock_.file(), lock_folder(out()) / "another"); }

  Result<Receipt> store(TileId tile) {
    CollectedTile empty;
    empty.mesh.dimension = 3;
    std::promise<Result<Receipt>> stored;
    store_->store(tile, std::move(empty), [&](Result<Receipt> receipt) { stored.set_value(std::move(receipt)); });
    return stored.get_future().get();
  }

  std::set<fs::path> files() const {
    std::set<fs::path> names;
    for (const auto& entry : fs::recursive_directory_iterator(out())) names.insert(entry.path());
    return names;
  }

  static constexpr TileId tile{7};
  const BigVector<std::byte> bytes_{std::byte{1}, std::byte{2}};
  TemporaryFolder folder_ = TemporaryFolder::make().value();
  FolderLock lock_ = FolderLock::take(folder_.path()).value();
  std::shared_ptr<RoutedCloud> run_ = std::make_shared<RoutedCloud>();
  std::optional<DiskScratch> storage_;
  std::optional<DiskStore> store_;
};

// All kinds, of a tile's own or of another run with the same tiles.
TEST_F(LockedScratch, GivesNoTileWhatAnotherHasWritten) {
  constexpr TileId other{8};
  for (const ScratchKind what : {ScratchKind::state, ScratchKind::finals, ScratchKind::mail, ScratchKind::duplicates}) {
    ASSERT_TRUE(storage_->write(tile, what, bytes_));
    ASSERT_TRUE(storage_->write(other, what, bytes_));
    fs::rename(scratch_file(run_->folder, what, other), scratch_file(run_->folder, what, tile));
    EXPECT_EQ(storage_->read(tile, what).error().code, Errc::corrupt);
    ASSERT_TRUE(storage_->write(tile, what, bytes_));
    run_->seal += 1;
    open({.lock_file = lock_.file()});
    EXPECT_EQ(storage_->read(tile, what).error().code, Errc::corrupt);
    run_->seal -= 1;
    open({.lock_file = lock_.file()});
    EXPECT_EQ(storage_->read(tile, what).value(), TileStorage::Pieces{bytes_});
  }
  ASSERT_TRUE(storage_->hand_over(other, bytes_));
  fs::rename(handed_file(run_->folder, other), handed_file(run_->folder, tile));
  EXPECT_EQ(storage_->handed(tile).error().code, Errc::corrupt);
}

TEST_F(LockedScratch, WritesAndRemovesWhileTheLockIsItsOwn) {
  EXPECT_TRUE(storage_->write(tile, ScratchKind::state, bytes_));
  EXPECT_TRUE(storage_->append(tile, ScratchKind::mail, bytes_));
  EXPECT_EQ(storage_->read(tile, ScratchKind::mail).value(), TileStorage::Pieces{bytes_});
  EXPECT_TRUE(storage_->write(tile, ScratchKind::settled, bytes_));
  EXPECT_TRUE(storage_->has(tile, ScratchKind::settled).value());
  EXPECT_EQ(storage_->read(tile, ScratchKind::settled).value(), TileStorage::Pieces{bytes_});
  EXPECT_TRUE(storage_->clear(ScratchKind::settled));
  EXPECT_TRUE(storage_->read(tile, ScratchKind::settled).value().empty());
  EXPECT_TRUE(mark_settled(run_->folder, 0, lock_.file(), true));
  EXPECT_TRUE(storage_->clear(ScratchKind::mail));
  const auto receipt = store(tile);
  ASSERT_TRUE(receipt);
  EXPECT_EQ(tile_entry_of(receipt.value())->tile, tile);
  EXPECT_TRUE(storage_->read(tile, ScratchKind::state).value().empty());  // not needed any more
  EXPECT_TRUE(fs::exists(tile_file(out(), tile)));
}

TEST_F(LockedScratch, AStoreThatIsStoppedLeavesNoFileAndWhatTheTileBeginsFrom) {
  std::stop_source stop;
  open({.lock_file = lock_.file(), .stop = stop.get_token()});
  ASSERT_TRUE(storage_->write(tile, ScratchKind::state, bytes_));
  stop.request_stop();
  const auto stored = store(tile);
  ASSERT_FALSE(stored);
  EXPECT_EQ(stored.error().code, Errc::interrupted);
  EXPECT_FALSE(fs::exists(tile_file(out(), tile)));
  EXPECT_EQ(storage_->read(tile, ScratchKind::state).value(), TileStorage::Pieces{bytes_});
  // Also in the middle of it.
  EXPECT_THROW((void)write_tile(out(), tile, TileMesh{}, {}, {.stop = stop.get_token()}), Stopped);
  EXPECT_TRUE(fs::is_empty(tiles_folder(out())));
}

TEST_F(LockedScratch, TouchesNothingOnceTheLockIsAnothers) {
  ASSERT_TRUE(storage_->write(tile, ScratchKind::state, bytes_));
  ASSERT_TRUE(storage_->append(tile, ScratchKind::mail, bytes_));
  take_the_lock_away();
  const auto before = files();
  const auto refused = [&](const auto& result) {
    return !result && result.error().code == Errc::io &&
           result.error().where ==
               out().string() +
                   ": this process was silent for so long that another process has taken the lock of the folder";
  };
  EXPECT_TRUE(refused(storage_->write(tile, ScratchKind::finals, bytes_)));
  EXPECT_TRUE(refused(storage_->write(tile, ScratchKind::settled, bytes_)));
  EXPECT_TRUE(refused(storage_->clear(ScratchKind::settled)));
  EXPECT_TRUE(refused(storage_->append(TileId{8}, ScratchKind::mail, bytes_)));
  EXPECT_TRUE(refused(storage_->remove(tile, ScratchKind::state)));
  EXPECT_TRUE(refused(storage_->clear(ScratchKind::mail)));
  EXPECT_TRUE(refused(store(tile)));
  EXPECT_TRUE(refused(mark_settled(run_->folder, 0, lock_.file(), true)));
  EXPECT_EQ(files(), before);
  // Also when it went while the tile was written.
  EXPECT_TRUE(refused(write_tile(out(), tile, TileMesh{}, {}, {true, {}, lock_.file(), {}})));
  EXPECT_TRUE(fs::is_empty(tiles_folder(out())));
}

}  // namespace
}  // namespace tessera
