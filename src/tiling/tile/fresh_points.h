// What one tile knows of fresh points while a stored result is changed (docs/updates-design.md): which vertices are
// fresh, of which of them the edges are still to be introduced, and what was quoted. A tile of a first triangulation
// has no such object.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include <tsl/robin_set.h>

#include "src/base/ids.h"
#include "src/base/mix_hash.h"
#include "src/base/point.h"
#include "src/geometry/kernel/kernel.h"

namespace tessera {

// A vertex is fresh when this tile knows it to be: a fresh point of its own, or a foreign point that came with the
// fresh bit. Not thread-safe.
class FreshPoints {
 public:
  FreshPoints() = default;
  // `own`: by vertex, from vertex 1 on: 1 for a fresh point. The edges of these are due.
  explicit FreshPoints(std::span<const std::uint8_t> own);

  bool has(Vertex v) const { return fresh_[v] != 0; }
  // Appends a vertex that is not known to be fresh.
  void add_vertex() { fresh_.push_back(0); }
  // Notes that a vertex that has just been appended is fresh. The caller introduces the edges of such vertices.
  void arrive(Vertex v) { fresh_[v] = 1; }
  // Notes that a vertex is fresh. If that is news, all its edges are due.
  void learn(Vertex v) {
    if (std::exchange(fresh_[v], std::uint8_t{1}) == 0) due_.push_back(v);
  }
  // Notes that all vertices are fresh; none is due any more.
  void learn_all();
  bool due() const { return !due_.empty(); }
  // Returns the vertices with edges that are due, and forgets them.
  std::vector<Vertex> take_due() { return std::exchange(due_, {}); }

  // Notes that a refused point is fresh. Returns whether that is news.
  bool learn_refused(PointId id) { return refused_.insert(id).second; }
  bool has_refused(PointId id) const { return refused_.contains(id); }

  // Notes that v is told to `tile` without the fresh bit. Returns false if that was noted before.
  bool add_quote(Vertex v, TileId tile) { return quoted_.insert(std::uint64_t{v} << 32 | tile.value).second; }
  // The same for a point that was refused. REQUIRES: all calls for one point follow each other.
  bool add_refused_quote(const SharedPoint& p, TileId tile);
  // Calls `tell` and `tell_refused` for all that was quoted to reborn tiles.
  void replay(const std::function<bool(TileId)>& reborn, const std::function<void(Vertex, TileId)>& tell,
              const std::function<void(const SharedPoint&, TileId)>& tell_refused) const;

  // For the image of a tile.
  struct RefusedQuote {
    SharedPoint point;
    TileId tile;  // to which the point was quoted
    std::uint32_t padding = 0;
  };
  struct State {
    std::vector<std::uint8_t> fresh;
    std::vector<Vertex> due;
    std::vector<std::uint64_t> quoted;  // vertex << 32 | tile
    std::vector<PointId> refused;
    std::vector<RefusedQuote> refused_quotes;
    // Whether all vertices are below `vertices`.
    bool fits(std::size_t vertices) const;
  };
  State state() const;
  // REQUIRES: state.fits(the number of vertices).
  explicit FreshPoints(State state);

  std::size_t memory() const {
    return fresh_.capacity() + due_.capacity() * sizeof(Vertex) +
           (quoted_.bucket_count() + refused_.bucket_count()) * 2 * sizeof(std::uint64_t) +
           refused_quotes_.capacity() * sizeof(RefusedQuote);
  }

 private:
  std::vector<std::uint8_t> fresh_;                // by vertex
  std::vector<Vertex> due_;                        // known before they became fresh
  tsl::robin_set<std::uint64_t, MixHash> quoted_;  // vertex << 32 | tile
  tsl::robin_set<PointId, MixHash> refused_;       // refused points that are fresh
  std::vector<RefusedQuote> refused_quotes_;
};

}  // namespace tessera
