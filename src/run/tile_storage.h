// Where a tile's bytes live while it runs: on disk in production, in memory in the harness.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <future>
#include <memory>
#include <span>
#include <vector>

#include "src/base/big_vector.h"
#include "src/base/ids.h"
#include "src/base/result.h"
#include "src/files/names.h"
#include "src/store/tile_store.h"
#include "src/tile/collected_tile.h"
#include "src/tile/early_finals.h"
#include "src/tiling/routed_run.h"

namespace tessera {

// What a tile puts on scratch outlives the process, but for mail: a resumed run begins from it.
// Calls for different tiles may come from different threads at once; those for one tile come one after the other.
class TileStorage {
 public:
  virtual ~TileStorage() = default;
  // Error corrupt when the points are not those that were routed.
  virtual Result<LoadedTile> load_points(TileId tile) = 0;

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

  // Keeps the early ones of these cells for store(), which gets what comes of this with the rest of the tile. May
  // return before, and wait before it does, so that few are under way.
  using StoredEarly = Result<BigVector<std::byte>>;
  virtual std::future<StoredEarly> store_early(TileId tile, std::shared_ptr<const EarlyFinals> cells) = 0;
  // The same bytes, of an earlier process or another node: an error when what they tell of cannot be gone on with.
  virtual Status take_early(TileId tile, BigVector<std::byte>& stored) = 0;

  // Keeps the result, and then tells `done`, from any thread. May return before. `done` does not throw, and is told
  // whatever happens, unless this throws.
  using Stored = std::function<void(Result<TileEntry>)>;
  virtual void store(TileId tile, CollectedTile collected, Stored done) = 0;
};

// Forgets what only a tile that is not stored needs, and what is as large as its points. Its foreign vertices stay
// until the run folder goes.
Status remove_beginnings(TileStorage& storage, TileId tile);

// Error corrupt: something of a tile on scratch is not what was put there.
Error damaged(TileId tile, const char* what);

// Whether a settled run has left what a tile is built from by itself. Whether it is sound, reading it will tell: once.
// An image tells it only where one node had the whole run.
Result<bool> can_be_built_alone(TileStorage& storage, TileId tile, bool many_nodes);

}  // namespace tessera
