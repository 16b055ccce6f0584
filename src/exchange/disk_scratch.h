// Keeps the scratch of a stage's tiles on disk: partly in a folder that all nodes of the job see, partly in the node's
// own.
#pragma once

#include <atomic>
#include <filesystem>

#include "src/base/files/frame.h"
#include "src/exchange/settled_files.h"
#include "src/exchange/tile_storage.h"

namespace tessera {

struct DiskScratchOptions {
  std::filesystem::path shared;     // folder for what other nodes need, too
  std::filesystem::path own;        // folder for tiles that are not in memory, and their mail
  std::uint64_t seal = 0;           // of the run: files of another run count as damaged
  std::filesystem::path lock_file;  // nothing is written or removed once another process has it (check_held())
  NodeId node;
};

class DiskScratch final : public TileStorage {
 public:
  explicit DiskScratch(DiskScratchOptions options);
  Status write(TileId tile, ScratchKind what, std::span<const std::byte> bytes) override;
  Status append(TileId tile, ScratchKind what, std::span<const std::byte> bytes) override;
  Result<Pieces> read(TileId tile, ScratchKind what) override;
  Result<bool> has(TileId tile, ScratchKind what) override;
  Status remove(TileId tile, ScratchKind what) override;
  Status clear(ScratchKind what) override;
  Status hand_over(TileId tile, std::span<const std::byte> bytes) override;
  Result<Pieces> handed(TileId tile) override;
  Status forget_handed(TileId tile) override;
  // Returns when what settled tiles have left is on the disk, synced. Error io.
  Status sync_settled() { return settled_.sync(); }
  bool own_scratch_failed() const override { return own_scratch_failed_; }

 private:
  const std::filesystem::path& folder_of(ScratchKind what) const;
  FrameOwner owner_of(TileId tile) const { return {options_.seal, tile.value}; }
  // Returns `outcome`. Notes an error io in the node's own folder, for own_scratch_failed().
  template <class Outcome>
  Outcome on(ScratchKind what, Outcome outcome);

  DiskScratchOptions options_;
  std::atomic<bool> own_scratch_failed_{false};
  SettledFiles settled_;
};

}  // namespace tessera
