// The triangulation T_i of one tile, and what the tile must tell others: star splaying by the rule of
// docs/design.md, section 2. Properties, for any order and batching of receive():
//  (1) When no tile has anything left to say, the cells with a vertex of this tile are those of the global Delaunay
//      triangulation of all points, cell for cell.
//  (2) A vertex is sent to a tile at most once, so the exchange ends.
//  (3) Work follows the cells a point creates, never the size of the tile.
// Source: Caraffa, Memari, Yirci, Bredif, Tile & Merge, IEEE Big Data 2019; Shewchuk, Star splaying, SoCG 2005.
// Not thread-safe: one actor owns one tile.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <stop_token>
#include <vector>

#include <tsl/robin_map.h>
#include <tsl/robin_set.h>

#include "src/base/big_vector.h"
#include "src/base/figures.h"
#include "src/base/mix_hash.h"
#include "src/base/point.h"
#include "src/base/result.h"
#include "src/base/stopped.h"
#include "src/geometry/kernel/kernel.h"
#include "src/tiling/tile/collected_tile.h"
#include "src/tiling/tile/final_cells.h"
#include "src/tiling/tile/known_from_start.h"
#include "src/tiling/tile/sent_set.h"

namespace tessera {

enum class ExchangeRule : std::uint8_t {
  introduce,  // whoever arrives hears of its neighbours: right, always
  published,  // simplify, then splay, as published: loses cells. Tests only
};

// What a tile has beside its own points and the cells that were discarded.
struct RestOfTile {
  std::uint64_t cells = 0, main_cells = 0;  // those with a vertex of the tile's own
  std::vector<SharedPoint> foreign;         // their foreign vertices
};

struct TileOptions {
  TileId self;
  int dimension = 3;
  KernelKind kernel = KernelKind::flat;
  ExchangeRule rule = ExchangeRule::introduce;
  const KnownFromStart* around = nullptr;  // outlives the tile
  // When it is requested, triangulate(), reduce(), receive(), introduce() and collect() soon throw Stopped: the tile
  // can then only be destroyed.
  std::stop_token stop = {};
};

class TileTriangulation {
 public:
  explicit TileTriangulation(const TileOptions& options);

  // Triangulates the tile's own points (distinct, in Hilbert order, ids beside them), with as many of its seeds as it
  // takes to span the space. The others follow in the first introduce(): once the neighbours' points are there, they
  // change little.
  // REQUIRES for (1): all tiles have the lexicographically least point of the cloud. If the seeds of each span the
  // space (as they do in production) the tile is never flat and the exchange stays small. `keep`: borrowed points must
  // stay where they are until collect().
  void triangulate(std::span<const Point> points, std::span<const PointId> ids, KeepPoints keep = KeepPoints::copied);

  // Takes the final cells out (those inside `box`) and keeps only what can still change. Call right after
  // triangulate(), with the same points. A kernel that cannot forget cells is built again from the others' vertices;
  // cells that fill the room of the removed ones are then told apart by a list of the local cells that are not final.
  // Vertices of final cells alone are forgotten, too, and no points are borrowed any more, unless `quick`, which spares
  // the time that takes.
  FinalCells reduce(std::span<const Point> points, const Box& box, bool quick = false);

  // The same for a caller who keeps nothing of the final cells: `told` sees their vertices, numbered as ids() were
  // before this call. Returns how many cells they are. collect_rest() then tells of the others.
  std::uint64_t discard(std::span<const Point> points, const Box& box, bool quick, const Kernel::TakeVertices& told);
  // By vertex, the infinite one first. Valid until the next call that changes the tile.
  std::span<const PointId> ids() const { return ids_; }

  // Directed first exchange: each neighbour hears of the vertices of open cells whose circumsphere reaches into its
  // bounds, but for cells whose sphere is large beside them. Only speeds things up. `points` as in triangulate().
  void announce(std::span<const Point> points, const Box& box);

  // Takes in points from another tile; introduce() ends a splay. Error internal, with a sentence, when no sound peer
  // can have sent them: a point that this tile owns, or other coordinates' twin under another id.
  Status receive(TileId from, std::span<const SharedPoint> points);

  // The rule of the exchange, for all that has come since the last call: the neighbours of each are told to its owner.
  void introduce();
  // Whether introduce() has anything to do.
  bool due() const { return !seeded_ || due_ <= kernel_->vertices() || !refused_.empty(); }

  // Everything that this tile has ever told others, or heard from them of points they do not own, becomes updates once
  // more: the way back into the exchange of a tile that begins from an image (docs/design.md, section 3).
  void replay();
  // Tiles (ascending) were reborn and know nothing: the same for these alone. Others may have died before what they had
  // told, as this tile was told, arrived: what it has relied on becomes updates, too, whomever it is for.
  void replay_to(std::span<const TileId> reborn);
  // Whom others have told of what: an earlier process's word, which holds no more. What this tile has told stays, for
  // it tells it again.
  void forget_words();
  // The foreign vertices: whatever cells the tile's own points have in the end, their other vertices are among these
  // once all tiles are quiet.
  std::vector<SharedPoint> foreign_vertices() const;

  // What others must now hear of, by tile, and forgets it. A tile is only ever told of points it does not own.
  std::map<TileId, std::vector<SharedPoint>> take_updates();

  // All cells with a vertex of this tile. `points`, `ids` as in triangulate(), best moved; `finals`: what reduce()
  // gave, or what is left of it. Right only once all tiles are quiet. The triangulation is gone afterwards.
  CollectedTile collect(std::vector<Point> points, std::vector<PointId> ids, PendingFinals finals);

  // For a caller who keeps no cells: `told` sees the vertices of the main cells, numbered as ids() are, but for cells
  // that discard() has told of. Right only once all tiles are quiet. The triangulation is gone afterwards.
  RestOfTile collect_rest(const Kernel::TakeVertices& told);

  const ExchangeCounts& counts() const { return counts_; }
  std::size_t memory() const;
  int kernel_dimension() const { return kernel_->dimension(); }
  // Whether reduce() has taken cells out, and whether it has forgotten vertices.
  bool handed_out() const { return handed_out_; }
  bool reduced() const { return reduced_; }

  // The whole state as bytes, to put a tile to sleep. REQUIRES: take_updates() has been called.
  BigVector<std::byte> save() const;
  // Restores it. False if the bytes are not what save() made for this tile, with a kernel of this kind.
  bool load(BigVector<std::byte> bytes);

 private:
  void forget_vertices(std::size_t own);
  FinalCells build_reduced(std::span<const Point> points, const std::function<bool(const Vertex*)>& is_final);
  std::vector<Vertex> renumber(std::span<const Vertex> used, std::size_t own);
  // The vertex, or 0 if it was refused; `around` are then those that would have been its neighbours.
  Result<Vertex> add_foreign(const SharedPoint& p, bool always, std::vector<Vertex>& around);
  struct Refused {
    SharedPoint point;
    TileId from;
  };
  Error refuse(TileId from, const SharedPoint& p) const;
  void add_seed(const Seed& seed);
  void introduce_vertices();
  void introduce(Vertex v, Vertex neighbour);
  void share_with_all();
  bool is_known_by(TileId tile, Vertex v) const;
  bool has_as_seed(TileId tile, Vertex v) const;
  bool record_sent(Vertex v, TileId tile);
  void record_received(Vertex v, TileId from, const SharedPoint& p);
  bool rely_on_told_bit(TileId tile, Vertex v);
  bool rely_on_told_bit_of_refused(TileId tile, const Refused& refused);
  void replay_if(const std::function<bool(TileId)>& reborn);
  SharedPoint shared(Vertex v) const { return {kernel_->point(v), ids_[v], owners_[v], told_[v]}; }
  void send(Vertex v, TileId tile);
  Status receive_published(TileId from, std::span<const SharedPoint> points);
  bool surely_final(const Vertex* cell, std::span<const Point> points, const Box& box) const;
  bool is_local(Vertex v) const { return v < owners_.size() && v != infinite_vertex && owners_[v] == options_.self; }

  static constexpr std::uint32_t points_a_look = 1024;  // some thousandths of a second

  TileOptions options_;
  std::unique_ptr<Kernel> kernel_;
  // By vertex; [0] is the infinite vertex.
  std::vector<PointId> ids_;
  std::vector<TileId> owners_;
  std::vector<std::uint32_t> ranks_;  // of local vertices in the order of triangulate(); empty: rank = vertex - 1
  tsl::robin_map<PointId, Vertex, MixHash> foreign_;  // by id: the vertex, or 0 once refused
  SentSet sent_;
  std::vector<std::uint32_t> told_;       // by vertex: SharedPoint::told
  tsl::robin_map<Vertex, double> seeds_;  // which vertices are seeds, and how far they reach
  Vertex due_ = 1;                        // the first vertex that has not been introduced
  std::vector<Refused> refused_;          // not introduced yet
  // This tile has not told it, for others have: rely_on_told_bit() of a vertex, and of a refused point. All of one
  // life.
  std::vector<std::uint64_t> relied_;  // vertex << 32 | tile, in the sent-set as well
  struct RefusedRelied {
    SharedPoint point;
    TileId tile;                // that has heard of it
    std::uint32_t by_word = 0;  // as others said; else it has said so itself, or has been told by this tile
  };
  std::vector<RefusedRelied> refused_relied_;
  bool seeded_ = false;  // all seeds are in
  bool handed_out_ = false, reduced_ = false;
  tsl::robin_set<CellKey, CellKeyHash> open_cells_;  // of a kernel built again: its all-local cells that are not fill
  std::map<TileId, std::vector<Vertex>> updates_;
  std::map<TileId, std::vector<SharedPoint>> refused_updates_;
  ExchangeCounts counts_;
  std::vector<Vertex> around_;  // scratch
  StopCheck stop_check_{options_.stop, points_a_look};
};

}  // namespace tessera
