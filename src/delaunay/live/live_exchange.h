// The exchange of the tiles that a batch wakes. Each tile that wakes is a copy of the tile of the version before, so
// readers of that version are not disturbed, and a batch that fails has changed nothing. The exchange goes in rounds,
// as UpdateExchange does: messages arrive in the next round, and all is quiet when a round sends nothing.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "src/base/result.h"
#include "src/delaunay/live/live_version.h"
#include "src/tiling/tile/tile_triangulation.h"

namespace tessera {

// What a batch does to vertices.
struct LiveBatch {
  std::map<TileId, std::vector<PointId>> removed;   // vertices, by owner
  std::map<TileId, std::vector<LocalPoint>> added;  // by owner; in Hilbert order, equal points by id
};

class LiveExchange {
 public:
  // All arguments outlive this object.
  LiveExchange(const LiveVersion& before, const KnownFromStart& around, const LiveBatch& batch, unsigned threads)
      : before_(before), around_(around), batch_(batch), threads_(threads) {
    for (const auto& [tile, ids] : batch.removed) removed_.insert(removed_.end(), ids.begin(), ids.end());
  }

  // Runs until all is quiet. Error internal when tiles tell each other what no sound tile tells.
  Status run();

  struct Woken {
    std::unique_ptr<TileTriangulation> triangulation;
    LiveChange change;
    bool mailed = false;  // woken by a message alone
    // Whether the cells of the tile may have changed.
    bool changed() const { return change.lost || change.begins || triangulation->counts().inserted > 0; }
  };
  // The tiles that were woken. They are not settled.
  std::map<TileId, Woken>& tiles() { return woken_; }

 private:
  using Mail = std::vector<std::pair<TileId, std::vector<SharedPoint>>>;
  std::set<TileId> beginners() const;
  Status wake(TileId id, Woken& tile) const;
  std::optional<SharedPoint> common() const;
  Status begin();
  Status round();
  void post(TileId from);
  template <class Work>
  Status for_each(const std::vector<TileId>& tiles, const Work& work);

  const LiveVersion& before_;
  const KnownFromStart& around_;
  const LiveBatch& batch_;
  unsigned threads_;
  std::vector<PointId> removed_;  // of all tiles
  std::map<TileId, Woken> woken_;
  std::map<TileId, Mail> mail_;
};

}  // namespace tessera
