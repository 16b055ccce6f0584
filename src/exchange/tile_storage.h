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

// What a tile writes to scratch, except its mail, outlives the process: a resumed run begins from it.
// Thread-safety: calls for different tiles may run at once; calls for one tile must come one after the other.
class TileStorage {
 public:
  virtual ~TileStorage() = default;
  using Pieces = std::vector<BigVector<std::byte>>;
  // Replaces what was there. Afterwards either the old or the new bytes are there, or damage that read() notices.
  virtual Status write(TileId tile, ScratchKind what, std::span<const std::byte> bytes) = 0;
  virtual Status append(TileId tile, ScratchKind what, std::span<const std::byte> bytes) = 0;
  // Returns what was written and appended, one piece for each call, or no piece when there was no call. Error corrupt
  // when something is damaged.
  virtual Result<Pieces> read(TileId tile, ScratchKind what) = 0;
  // Returns whether there is anything to read, sound or damaged.
  virtual Result<bool> has(TileId tile, ScratchKind what) = 0;
  virtual Status remove(TileId tile, ScratchKind what) = 0;
  virtual Status clear(ScratchKind what) = 0;  // for all tiles
  // Returns whether the system has refused access to the node's own scratch. Another node could then do what this one
  // cannot.
  virtual bool own_scratch_failed() const { return false; }

  // Like write(), read() and remove(), for the image that a tile leaves for the node on which it goes on. All nodes
  // that share a folder read what one of them has written.
  virtual Status hand_over(TileId, std::span<const std::byte>) {
    return error(Errc::internal, "a tile cannot be handed over: the nodes share no folder for it");
  }
  virtual Result<Pieces> handed(TileId) { return Pieces{}; }
  virtual Status forget_handed(TileId) { return success(); }
};

// Removes what only a tile before the end of its stage needs: its image, what stands beside the image, and the image
// that was handed over. What the tile has settled stays until the run folder is removed.
Status remove_beginnings(TileStorage& storage, TileId tile);

// Returns an error corrupt: the tile's `what` on scratch is not what was put there.
Error damaged(TileId tile, const char* what);

// Returns whether a settled run has left what the tile is built from without other tiles. This does not check that it
// is sound; reading it does. An image counts only when one node had the whole run.
Result<bool> can_be_built_alone(TileStorage& storage, TileId tile, bool many_nodes);

}  // namespace tessera
