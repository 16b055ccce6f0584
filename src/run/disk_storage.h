// A tile's bytes in a run folder, its result in the store.
#pragma once

#include <atomic>
#include <filesystem>
#include <future>
#include <memory>
#include <semaphore>
#include <vector>

#include "src/files/frame.h"
#include "src/mesh/tile_mesh.h"
#include "src/run/settled_files.h"
#include "src/run/tile_storage.h"
#include "src/run/writers.h"

namespace tessera {

class DiskStorage final : public TileStorage {
 public:
  // Scratch of tiles that are not in memory goes under `scratch`, what others need under run->folder, results to `out`;
  // error io before anything is written or removed there when the
  // lock of the options is another's. As many meshes are stored at a time as there are `writers`, which wait for the
  // disk while others work. What is being stored when this goes is waited for.
  DiskStorage(std::shared_ptr<const RoutedRun> run, std::filesystem::path scratch, std::filesystem::path out,
              StoreOptions options, std::uint32_t writers);
  Result<LoadedTile> load_points(TileId tile) override;
  Status write(TileId tile, ScratchKind what, std::span<const std::byte> bytes) override;
  Status append(TileId tile, ScratchKind what, std::span<const std::byte> bytes) override;
  Result<Pieces> read(TileId tile, ScratchKind what) override;
  Result<bool> has(TileId tile, ScratchKind what) override;
  Status remove(TileId tile, ScratchKind what) override;
  Status clear(ScratchKind what) override;
  Status hand_over(TileId tile, std::span<const std::byte> bytes) override;
  Result<Pieces> handed(TileId tile) override;
  Status forget_handed(TileId tile) override;
  // Written to the tile's file in `out`, under a temporary name.
  std::future<StoredEarly> store_early(TileId tile, std::shared_ptr<const EarlyFinals> cells) override;
  Status take_early(TileId tile, BigVector<std::byte>& stored) override;
  // The tile's scratch goes when its result is on disk.
  void store(TileId tile, CollectedTile collected, Stored done) override;
  // What settled tiles have left has reached the disk. Error io.
  Status sync_settled() { return settled_.sync(); }
  bool own_scratch_failed() const override { return own_scratch_failed_; }

 private:
  const std::filesystem::path& folder_of(ScratchKind what) const;
  FrameOwner owner_of(TileId tile) const { return {run_->seal, tile.value}; }
  // What came of it on scratch, which is noted when it could not be used, and is the node's own.
  template <class Outcome>
  Outcome on(ScratchKind what, Outcome outcome);
  Result<std::vector<std::byte>> gather_rows(const TileMesh& mesh) const;
  template <class Write>
  auto written(TileId tile, const Write& write) const noexcept -> decltype(write());
  StoredEarly write_early(TileId tile, const EarlyFinals& cells) const;
  Result<TileEntry> write_result(TileId tile, const CollectedTile& collected);

  std::shared_ptr<const RoutedRun> run_;
  std::filesystem::path scratch_, out_;
  std::atomic<bool> own_scratch_failed_{false};
  StoreOptions options_;
  SettledFiles settled_;
  std::counting_semaphore<> early_;  // how many more may be stored early now
  Writers writers_;                  // last: they use all of the above
};

}  // namespace tessera
