// Where the tiles of one stage keep bytes while they run: on disk in production, in memory in the harness.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "src/base/big_vector.h"
#include "src/base/files/names.h"
#include "src/base/ids.h"
#include "src/base/result.h"

namespace tessera {

// What a tile puts on scratch outlives the process, but for mail: a resumed run begins from it.
// Calls for different tiles may come from different threads at once; those for one tile come one after the other.
class TileStorage {
 public:
  virtual ~TileStorage() = default;
  using Pieces = std::vector<BigVector<std::byte>>;
  // Replaces what was there: whatever happens, afterwards the old or the new bytes are there, or damage that read()
  // notices.
  virtual Status write(TileId tile, ScratchKind what, std::span<const std::byte> bytes) = 0;
  virtual Status append(TileId tile, ScratchKind what, std::span<const std::byte> bytes) = 0;
  // What was written and appended, a piece a call; none if nothing was. Error corrupt when it is damaged.
  virtual Result<Pieces> read(TileId tile, ScratchKind what) = 0;
  // Whether there is anything to read, sound or not.
  virtual Result<bool> has(TileId tile, ScratchKind what) = 0;
  virtual Status remove(TileId tile, ScratchKind what) = 0;
  virtual Status clear(ScratchKind what) = 0;  // of all tiles
  // Whether the system has refused scratch that is one node's own: another node can do what this one cannot.
  virtual bool own_scratch_failed() const { return false; }

  // For whichever node begins the tile next, where nodes share a folder: as write(), read() and remove(), but that all
  // of them read what one has written.
  virtual Status hand_over(TileId, std::span<const std::byte>) {
    return error(Errc::internal, "there is nobody to hand a tile over to");
  }
  virtual Result<Pieces> handed(TileId) { return Pieces{}; }
  virtual Status forget_handed(TileId) { return success(); }
};

// Forgets what only a tile that has not come to the end of its stage needs: its image, and what stands beside it. What
// it has settled stays until the run folder goes.
Status remove_beginnings(TileStorage& storage, TileId tile);

// Error corrupt: something of a tile on scratch is not what was put there.
Error damaged(TileId tile, const char* what);

// Whether a settled run has left what a tile is built from by itself. Whether it is sound, reading it will tell: once.
// An image tells it only where one node had the whole run.
Result<bool> can_be_built_alone(TileStorage& storage, TileId tile, bool many_nodes);

}  // namespace tessera
