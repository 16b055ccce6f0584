// The triangulation T_i of one tile, and what the tile must tell other tiles: star splaying by the rule of
// docs/design.md, section 2. Properties, for any order and batching of receive():
//  (1) When no tile has anything left to send, the cells with a vertex of this tile are those of the global Delaunay
//      triangulation of all points, cell for cell.
//  (2) A vertex is sent to a tile at most once, so the exchange ends.
//  (3) The work depends on the cells that a point creates, never on the size of the tile.
// Sources: Caraffa, Memari, Yirci, Bredif, Tile & Merge, IEEE Big Data 2019; Shewchuk, Star splaying, SoCG 2005.
// Not thread-safe: one actor owns one tile.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <utility>
#include <vector>

#include <tsl/robin_map.h>
#include <tsl/robin_set.h>

#include "src/base/big_vector.h"
#include "src/base/figures.h"
#include "src/base/image.h"
#include "src/base/mix_hash.h"
#include "src/base/point.h"
#include "src/base/result.h"
#include "src/base/stopped.h"
#include "src/geometry/kernel/kernel.h"
#include "src/tiling/tile/collected_tile.h"
#include "src/tiling/tile/final_cells.h"
#include "src/tiling/tile/fresh_points.h"
#include "src/tiling/tile/known_by_message.h"
#include "src/tiling/tile/known_from_start.h"

namespace tessera {

enum class ExchangeRule : std::uint8_t {
  introduce,  // a point that arrives is introduced to its neighbours: always right
  published,  // simplify, then splay, as published: loses cells. For tests only
};

// A part of the rule by which a stored result is changed that a tile does not obey. For tests only: without any of
// these parts some results are wrong.
enum class LeftOut : std::uint8_t {
  nothing,
  foreign_pairs,    // two foreign vertices are introduced
  old_arrivals,     // the edges of a point that arrives and is not fresh
  refused_fresh,    // a fresh point that was refused is introduced
  answers,          // a vertex that is known, and is now told of as fresh, is answered
  replayed_quotes,  // quotes are repeated for reborn tiles
  // And what settle() forgets:
  forgotten_sent,
  forgotten_fresh,
  forgotten_refused,
};

// What a tile begins from when a stored result is changed (docs/updates-design.md).
struct ChangedTile {
  std::span<const Point> points;         // the tile's own points that stay, and new ones; distinct, in Hilbert order
  std::span<const PointId> ids;          // beside points
  std::span<const std::uint8_t> fresh;   // beside points: 1 for a fresh point
  std::span<const SharedPoint> foreign;  // the foreign vertices of the stored cells that stay; best in Hilbert order
  // One point for all tiles, with its fresh bit. A point that stays, unless none does. A tile without fresh points
  // needs none.
  std::optional<SharedPoint> common = {};
};

// What a change does to a live tile itself.
struct LiveChange {
  bool lost = false;                                    // an own point is gone
  bool begins = false;                                  // the tile has fresh points
  std::vector<std::pair<PointId, PointId>> duplicates;  // added points that are equal to others: (duplicate, kept)
};

// What a tile has besides its own points and the cells that were discarded.
struct RestOfTile {
  std::uint64_t cells = 0, main_cells = 0;  // of the cells with a vertex of the tile's own
  std::vector<SharedPoint> foreign;         // the foreign vertices of these cells
};

struct TileOptions {
  TileId self;
  int dimension = 3;
  KernelKind kernel = KernelKind::flat;
  ExchangeRule rule = ExchangeRule::introduce;
  const KnownFromStart* around = nullptr;  // outlives the tile
  // Once it is requested, triangulate(), reduce(), receive(), introduce() and collect() soon throw Stopped. The tile
  // can then only be destroyed.
  std::stop_token stop = {};
  LeftOut left_out = LeftOut::nothing;
  // A live tile is built again when more than one in so many of its vertices go: to remove a vertex costs some five
  // times as much as to insert one. 0: only when most of its vertex numbers are unused.
  std::size_t rebuilt_from = 5;
};

class TileTriangulation {
 public:
  explicit TileTriangulation(const TileOptions& options);

  // Triangulates the tile's own points (distinct, in Hilbert order, with their ids), and as many of its seeds as it
  // needs to span space. The other seeds follow in the first introduce(): once the neighbours' points are there, seeds
  // change little.
  // REQUIRES for (1): all tiles have the lexicographically least point of the cloud. If the seeds of each tile span
  // space (in production they do), the tile is never flat and the exchange stays small. `keep`: borrowed points must
  // stay where they are until collect().
  void triangulate(std::span<const Point> points, std::span<const PointId> ids, KeepPoints keep = KeepPoints::copied);

  // Takes the place of triangulate() when a stored result is changed: triangulates what the tile keeps of it, and what
  // is new. From then on the tile introduces only pairs with a point that it knows to be fresh. Such a tile is not
  // reduced and does not announce. `around` of the options has no seeds, and has left out the fresh bit. Error internal
  // when two points have the same coordinates.
  Status triangulate_changed(const ChangedTile& changed, KeepPoints keep = KeepPoints::copied);

  // Takes the final cells out (cells whose circumsphere is inside `box`), and keeps only what can still change. Call
  // right after triangulate(), with the same points. A kernel that cannot freeze cells is built again from the vertices
  // of the other cells; its fill cells are then told apart by a list of the open local cells. Unless `quick`, vertices
  // without open cells are forgotten, too, and the kernel borrows no points any more; that takes time.
  FinalCells reduce(std::span<const Point> points, const Box& box, bool quick = false);

  // The same for a tile that keeps no final cells: `told` is called with their vertices, numbered as ids() were before
  // this call. Returns the number of these cells. collect_rest() later tells of the other cells.
  std::uint64_t discard(std::span<const Point> points, const Box& box, bool quick, const Kernel::TakeVertices& told);
  // By vertex, the infinite vertex first. Valid until the next call that changes the tile.
  std::span<const PointId> ids() const { return ids_; }

  // The first exchange: each neighbour is sent the vertices of open cells whose circumsphere reaches well into its
  // bounds, except for cells whose sphere is large beside them. Only speeds things up. `points` as in triangulate().
  void announce(std::span<const Point> points, const Box& box);

  // Takes in points from another tile; introduce() ends the splay. Error internal, with a sentence, when no sound peer
  // can have sent them: this tile owns a point, or a point has the coordinates of another one with another id.
  Status receive(TileId from, std::span<const SharedPoint> points);

  // Applies the rule of the exchange to all points that have come since the last call: introduces each to its
  // neighbours.
  void introduce();
  // Whether introduce() has anything to do.
  bool due() const { return !seeded_ || due_ <= kernel_->vertices() || !refused_.empty() || (fresh_ && fresh_->due()); }

  // Prepares updates that repeat everything that this tile has ever sent, or knows from messages that others know. A
  // tile that begins from an image comes back into the exchange this way (docs/recovery.md).
  void replay();
  // The same for reborn tiles alone (ascending), which know nothing. Other tiles may have died before their messages
  // arrived, though this tile was told of these messages. So what this tile has relied on becomes updates, too, for
  // whichever tile it is.
  void replay_to(std::span<const TileId> reborn);
  // Forgets the told bits: what an earlier process said holds no more. What this tile itself has sent stays, because it
  // sends that again.
  void forget_told_bits() { known_.forget_told_bits(owners_); }
  // Returns the foreign vertices. Once all tiles are quiet, the cells of the tile's own points have no other foreign
  // vertices than these.
  std::vector<SharedPoint> foreign_vertices() const;

  // Returns, by tile, what the other tiles must now be sent, and forgets it. A tile is only sent points that it does
  // not own. What the tile tells its own images it tells itself, in introduce().
  std::map<TileId, std::vector<SharedPoint>> take_updates();

  // Returns all cells with a vertex of this tile. `points` and `ids` are those of triangulate(), best moved; `finals`
  // is what reduce() returned, or what is left of it. Right only once all tiles are quiet. The triangulation is gone
  // afterwards.
  CollectedTile collect(std::vector<Point> points, std::vector<PointId> ids, PendingFinals finals);

  // For a tile that keeps no cells: `told` is called with the vertices of the main cells, numbered as ids() are, except
  // for the cells that discard() has reported. Right only once all tiles are quiet. The triangulation is gone
  // afterwards.
  RestOfTile collect_rest(const Kernel::TakeVertices& told);

  // The following functions are for a live tile: one that stays in memory while a result is changed again and again.
  // It begins by triangulate_changed() without fresh points, or as a tile without points. Then each change is:
  // settle(); change(); know() for the other points that the tile is to know from the start; receive() and introduce()
  // until all is quiet. A live tile can be neither reduced, saved nor collected; see mesh() instead.
  //
  // Forgets what was told, heard and refused, and which points are fresh. Call once all is quiet.
  void settle();
  // Takes the vertices `removed` out, and inserts `added`, points of this tile with new ids. Ids that the tile does not
  // know are passed over. If the tile has not been awake for some changes, `removed` has the ids of those, too.
  // REQUIRES: settle(); of equal points in `added` the first has the least id. Hilbert order makes it fast. Error
  // internal when a foreign vertex has the place of an added point. After an error the tile can only be destroyed.
  Result<LiveChange> change(std::span<const PointId> removed, std::span<const LocalPoint> added);
  // Inserts points of other tiles, all of which stay. Error internal as above.
  Status know(std::span<const SharedPoint> points);
  // Inserts the common point, unless the tile has one that serves as well. With its fresh bit, if all points are new.
  Status know_common(const SharedPoint& common);
  // At most `most` of the own points that are fresh and were there before the change, spread evenly.
  std::vector<SharedPoint> affected(std::size_t most) const;
  // An own point that was there before the change, if there is one.
  std::optional<SharedPoint> old_point() const;
  // An own point with its fresh bit, when all are new. REQUIRES: own_points() > 0, no old_point().
  SharedPoint new_point() const;
  // The bounds of the fresh own points and of all their neighbours: each new cell of the whole triangulation lies in
  // these bounds of some tile. Empty before change(), and after settle().
  Bounds changed() const;
  // Returns a copy. REQUIRES: settle().
  std::unique_ptr<TileTriangulation> clone() const;
  // Gives foreign vertices other owners, because a tile was split. `owner_of` gets the owner so far. REQUIRES:
  // settle(); this tile was not split.
  void change_owners(const std::function<TileId(TileId owner, const Point& at)>& owner_of);
  // The vertex of a point, or 0. REQUIRES: a live tile.
  Vertex vertex_of(PointId id) const;
  bool is_own(Vertex v) const { return is_local(v); }
  TileId owner(Vertex v) const { return owners_[v]; }
  std::size_t own_points() const { return local_.size(); }
  std::vector<LocalPoint> own() const;
  const Kernel& kernel() const { return *kernel_; }
  // The cells with a vertex of this tile. `order`: the own points, in Hilbert order. REQUIRES: not flat.
  TileMesh mesh(std::span<const LocalPoint> order) const;

  const ExchangeCounts& counts() const { return counts_; }
  std::size_t memory() const;
  int kernel_dimension() const { return kernel_->dimension(); }
  // Whether reduce() has taken cells out, and whether vertices have been forgotten.
  bool handed_out() const { return handed_out_; }
  bool reduced() const { return reduced_; }

  // Returns the whole state as bytes, so that the tile can sleep. REQUIRES: take_updates() has been called.
  BigVector<std::byte> save() const;
  // Restores the state. Returns false if the bytes are not what save() made of this tile, with a kernel of this kind.
  bool load(BigVector<std::byte> bytes);

 private:
  void forget_vertices(std::size_t own);
  FinalCells build_reduced(std::span<const Point> points, const std::function<bool(const Vertex*)>& is_final);
  std::vector<Vertex> renumber(std::span<const Vertex> used, std::size_t own);
  // Returns the vertex, or 0 if the point was refused; `around` then has the vertices that would have been its
  // neighbours.
  Result<Vertex> add_foreign(const SharedPoint& p, bool always, std::vector<Vertex>& around);
  struct Refused {
    SharedPoint point;
    TileId from;
  };
  Error refuse(TileId from, const SharedPoint& p) const;
  void add_seed(const Seed& seed);
  void introduce_vertices();
  void introduce(Vertex v, Vertex neighbour);
  void introduce_due();
  bool introduce_refused(const Refused& r);
  void introduce_once();
  template <class Visit>
  void edges_due(const Visit& visit);
  void shorten_edges();
  void shorten(const SharedPoint& p, const SharedPoint& q);
  void add_image(const SharedPoint& p, const PeriodOffset& by);
  SharedPoint seen_from(TileId tile, const SharedPoint& p) const;
  void tell_self();
  void share_with_all();
  void build(std::span<const Point> points, std::span<const PointId> ids, KeepPoints keep);
  bool needs(const SharedPoint& common) const;
  bool is_settled() const {
    return seeded_ && !handed_out_ && due_ == ids_.size() && (!fresh_ || options_.left_out == LeftOut::forgotten_fresh);
  }
  Status build_again(const std::vector<std::uint8_t>& gone, std::vector<std::uint8_t>& fresh);
  Status receive_first(TileId from, const SharedPoint& p);
  Status receive_changed(TileId from, SharedPoint p);
  bool is_fresh(Vertex v) const { return !fresh_ || fresh_->has(v); }
  void quote(Vertex v, TileId tile);
  void quote_refused(const SharedPoint& p, TileId tile);
  bool is_known_by(TileId tile, Vertex v) const;
  bool has_as_seed(TileId tile, Vertex v) const;
  // Of a sender that is periodic the tile does not know which image has spoken, so only what it says is noted.
  void record_received(Vertex v, TileId from, const SharedPoint& p) {
    if (options_.around->periodic()) return known_.record_quoted(v, p.told);
    known_.record_received(v, owners_[v], from, p.told);
  }
  void replay_if(const std::function<bool(TileId)>& reborn);
  SharedPoint shared(Vertex v) const {
    const std::uint32_t fresh = fresh_ && fresh_->has(v) ? fresh_bit : 0;
    return {kernel_->point(v), ids_[v], owners_[v], known_.told(v) | fresh};
  }
  void send(Vertex v, TileId tile);
  Status receive_published(TileId from, std::span<const SharedPoint> points);
  bool surely_final(const Vertex* cell, std::span<const Point> points, const Box& box) const;
  bool is_local(Vertex v) const { return v < owners_.size() && v != infinite_vertex && owners_[v] == options_.self; }

  static constexpr std::uint32_t points_a_look = 1024;  // some thousandths of a second between two looks at `stop`

  TileOptions options_;
  std::unique_ptr<Kernel> kernel_;
  // By vertex; [0] is the infinite vertex.
  std::vector<PointId> ids_;
  std::vector<TileId> owners_;
  std::vector<std::uint32_t> ranks_;  // of local vertices in the order of triangulate(); empty: the rank is vertex - 1
  tsl::robin_map<PointId, Vertex, MixHash> foreign_;  // by id: the vertex, or 0 if it was refused
  tsl::robin_map<PointId, Vertex, MixHash> local_;    // of a live tile: its own points by id
  Vertex live_from_ = 1;                              // of a live tile: the first vertex that this change has added
  KnownByMessage known_;
  std::optional<FreshPoints> fresh_;      // while a stored result is changed
  tsl::robin_map<Vertex, double> seeds_;  // which vertices are seeds, and their reach
  Vertex due_ = 1;                        // the first vertex that has not been introduced
  std::vector<Refused> refused_;          // not introduced yet
  bool seeded_ = false;                   // all seeds are inserted
  bool handed_out_ = false, reduced_ = false;
  // if the kernel was built again: its all-local cells that are not fill
  tsl::robin_set<CellKey, CellKeyHash> open_cells_;
  std::map<TileId, std::vector<Vertex>> updates_;
  std::map<TileId, std::vector<SharedPoint>> refused_updates_;
  ExchangeCounts counts_;
  std::vector<Vertex> around_;  // scratch
  StopCheck stop_check_{options_.stop, points_a_look};
};

}  // namespace tessera
