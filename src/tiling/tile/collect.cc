#include "src/tiling/tile/collect.h"

#include <tsl/robin_map.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>
#include <utility>

#include "src/base/check.h"
#include "src/base/image.h"
#include "src/base/stopped.h"
#include "src/tiling/tile/sorted_cells.h"

namespace tessera {
namespace {

template <int d>
class Collector {
 public:
  explicit Collector(CollectInput input) : in_(std::move(input)) {}

  CollectedTile make() {
    mesh_.dimension = d;
    for (const auto step : {&Collector::classify, &Collector::number_vertices, &Collector::link_to_others,
                            &Collector::append_final_cells, &Collector::bucket_cells, &Collector::sort}) {
      throw_if_stopped(in_.stop);
      (this->*step)();
    }
    return std::move(tile_);
  }

 private:
  static constexpr int corners = d + 1;
  // Neighbours in rows that are no cells: outside the hull, or in another tile.
  static constexpr std::uint32_t across_outside = ~0u - 3, across_elsewhere = ~0u - 7;
  // Values of least_ for cells that are not kept.
  static constexpr std::uint32_t gap = ~0u, other = ~0u - 1, fill = ~0u - 2;

  bool kept(std::size_t c) const { return (least_[c] & ~mixed_row) < own_; }

  // Returns the mesh indices of cell c.
  std::array<std::uint32_t, corners> indices(std::size_t c) const {
    std::array<std::uint32_t, corners> v;
    for (int i = 0; i < corners; ++i) {
      const std::uint32_t w = in_.cells[c].vertices[i];
      v[i] = w <= own_ ? w - 1 : index_[w - own_ - 1];
    }
    return v;
  }

  static CellKey facet_key(const std::array<std::uint32_t, corners>& vertices, int opposite) {
    CellKey key{~0u, ~0u, ~0u, ~0u};
    int n = 0;
    for (int i = 0; i < corners; ++i) {
      if (i != opposite) key[n++] = vertices[i];
    }
    std::sort(key.begin(), key.end());
    return key;
  }

  // Decides which cells are kept: those with a vertex of the tile's own. Foreign vertices are used if they are in a
  // kept cell.
  void classify() {
    const std::size_t count = in_.cells.size();
    least_.resize(count);
    index_.assign(in_.foreign.size(), unused);
    end_.assign(std::size_t{own_} + 1, 0);
    const bool filled = !in_.fill.empty();
    for (std::size_t c = 0; c < count; ++c) {
      const std::uint32_t* v = in_.cells[c].vertices;
      const auto [low, high] = extremes(v);
      const bool has_own = low - 1 < own_;  // 0, the infinite vertex, becomes the greatest
      if (has_own && high <= own_ && !filled) [[likely]] {
        keep(c, low - 1, 0);
      } else if (v[0] == CellRecord::gap) {
        least_[c] = gap;
      } else if (!has_own || (filled && in_.fill[c])) {
        least_[c] = has_own ? fill : other;
        others_.push_back(static_cast<std::uint32_t>(c));
      } else {
        keep(c, low - 1, high > own_ ? mixed_row : 0);
        for (int i = 0; i < corners; ++i) {
          if (v[i] > own_) index_[v[i] - own_ - 1] = 0;
        }
      }
    }
  }

  void keep(std::size_t c, std::uint32_t least, std::uint32_t mixed) {
    least_[c] = least | mixed;
    ++end_[least + 1];
  }

  static std::pair<std::uint32_t, std::uint32_t> extremes(const std::uint32_t* v) {
    std::uint32_t low = v[0], high = v[0];
    for (int i = 1; i < corners; ++i) {
      low = v[i] < low ? v[i] : low;
      high = v[i] > high ? v[i] : high;
    }
    return {low, high};
  }

  // Numbers the vertices: own points by rank, then the used foreign vertices by id.
  void number_vertices() {
    std::vector<std::uint32_t> order;
    for (std::uint32_t k = 0; k < index_.size(); ++k) {
      if (index_[k] != unused) order.push_back(k);
    }
    std::sort(order.begin(), order.end(), [&](auto a, auto b) {
      const PointId p = in_.foreign[a].id, q = in_.foreign[b].id;
      return plain(p) != plain(q) ? plain(p) < plain(q) : p < q;
    });
    const std::size_t n = own_ + order.size();
    mesh_.points = std::move(in_.points);
    mesh_.ids = std::move(in_.ids);
    mesh_.points.reserve(n);
    mesh_.ids.reserve(n);
    mesh_.owners.reserve(n);
    mesh_.point_ghost.reserve(n);
    mesh_.owners.assign(own_, in_.self);
    bool images = false;
    for (const std::uint32_t k : order) {
      const SharedPoint& p = in_.foreign[k];
      index_[k] = static_cast<std::uint32_t>(mesh_.points.size());
      mesh_.points.push_back(p.at);
      mesh_.ids.push_back(plain(p.id));
      mesh_.owners.push_back(p.tile);
      images |= offset_code(p.id) != 0;
    }
    if (images) number_images(order);
    mesh_.point_ghost.assign(own_, 0);
    mesh_.point_ghost.resize(n, 1);
  }

  // Of images the mesh has owners without offsets, and offsets apart. Which cells are main follows from both.
  void number_images(const std::vector<std::uint32_t>& order) {
    mesh_.offsets.assign(mesh_.points.size(), 0);
    ranks_.assign(own_, rank_of(in_.self));
    for (std::size_t v = own_; v < mesh_.owners.size(); ++v) {
      mesh_.offsets[v] = static_cast<std::uint8_t>(offset_code(in_.foreign[order[v - own_]].id));
      ranks_.push_back(rank_of(mesh_.owners[v]));
      mesh_.owners[v] = plain(mesh_.owners[v]);
    }
  }

  // Kept cells know their kept neighbours already. The other cells, which are few, tell their kept neighbours what lies
  // across.
  void link_to_others() {
    for (const std::uint32_t c : others_) {
      const std::uint32_t* v = in_.cells[c].vertices;
      const bool infinite = std::find(v, v + corners, infinite_vertex) != v + corners;
      for (int i = 0; i < corners; ++i) {
        const std::uint32_t across = in_.cells[c].neighbors[i];
        if (across & across_frozen) continue;
        const std::uint32_t n = across / 4, k = across % 4;
        if (infinite && v[i] == infinite_vertex && least_[n] == fill) {
          // A final cell is at the hull: its facet is a facet of an infinite cell.
          borders_[facet_key(indices_but(c, i), i)] = across_outside;
        }
        if (!kept(n)) continue;
        if (least_[c] == fill) {
          borders_[facet_key(indices(n), static_cast<int>(k))] = across;
        } else {
          in_.cells[n].neighbors[k] =
              infinite && facet_has_own_vertex(n, static_cast<int>(k)) ? across_outside : across_elsewhere;
        }
      }
    }
    others_ = {};
  }

  // The same as indices(c) for a cell whose vertex `but` may be infinite.
  std::array<std::uint32_t, corners> indices_but(std::size_t c, int but) const {
    std::array<std::uint32_t, corners> v{};
    for (int i = 0; i < corners; ++i) {
      const std::uint32_t w = in_.cells[c].vertices[i];
      if (i != but) v[i] = w <= own_ ? w - 1 : index_[w - own_ - 1];
    }
    return v;
  }

  // Whether a facet has a vertex of the tile's own. What lies across other facets is known to the tiles of their
  // vertices, not here. REQUIRES: c is kept.
  bool facet_has_own_vertex(std::uint32_t c, int opposite) const {
    for (int i = 0; i < corners; ++i) {
      if (i != opposite && in_.cells[c].vertices[i] <= own_) return true;
    }
    return false;
  }

  // Appends the final cells, which know each other. A kernel that froze them knows what else they border. If the kernel
  // was built again, borders_ has the common facets.
  void append_final_cells() {
    PendingFinals finals = std::exchange(in_.finals, {});
    tile_.early = finals.early;
    const auto shift = static_cast<std::uint32_t>(in_.cells.size());
    const std::size_t count = finals.cells.rows.size();
    if (count == 0) return;
    if (shift + count > CellRecord::most) throw KernelFull();
    CellRecords& cells = in_.cells;
    cells.resize(shift + count);
    for (std::size_t c = 0; c < count; ++c) {
      CellRecord& row = cells[shift + c] = finals.cells.rows[c];
      for (int i = 0; i < corners; ++i) {
        std::uint32_t& n = row.neighbors[i];
        if (n == FinalCells::open) continue;
        n = n & PendingFinals::written ? across_written(n & ~PendingFinals::written, shift + count) : n + 4 * shift;
      }
    }
    if (shift + count + written_.size() > CellRecord::most) throw KernelFull();
    const RowsOfFrozen rows(finals);
    for (std::size_t c = 0; c < shift; ++c) {
      if (least_[c] == gap) continue;
      for (int i = 0; i < corners; ++i) {
        std::uint32_t& n = cells[c].neighbors[i];
        if (n >= across_elsewhere || !(n & across_frozen)) continue;
        const std::uint32_t facet = n & ~across_frozen;
        const std::size_t row = rows.of(facet / corners);
        check_read(row < count && cells[shift + row].neighbors[facet % corners] == FinalCells::open,
                   "a facet of the hole is none of a final cell");
        n = static_cast<std::uint32_t>(4 * (shift + row));
        cells[shift + row].neighbors[facet % corners] = kept(c) ? static_cast<std::uint32_t>(4 * c) : across_outside;
      }
    }
    for (std::size_t c = 0; c < count; ++c) {
      CellRecord& row = cells[shift + c];
      for (int i = 0; i < corners; ++i) {
        if (row.neighbors[i] != FinalCells::open) continue;
        const auto border = borders_.find(facet_key(indices(shift + c), i));
        check_read(border != borders_.end(), "an open facet of a final cell borders no kept cell");
        const std::uint32_t across = row.neighbors[i] = border->second;
        if (across == across_outside) continue;
        cells[across / 4].neighbors[across % 4] = 4 * (shift + static_cast<std::uint32_t>(c));
      }
    }
    place_final_cells(finals, shift);
  }

  // Returns a neighbour number for a cell that was written early: a row beyond the last one. `mesh_index` tells which
  // cell it is.
  std::uint32_t across_written(std::uint32_t mesh_index, std::size_t rows) {
    written_.push_back(static_cast<std::int32_t>(mesh_index));
    return static_cast<std::uint32_t>(4 * (rows + written_.size() - 1));
  }

  // Final cells with a known mesh_index go there, before all cells that are to be sorted.
  void place_final_cells(const PendingFinals& finals, std::uint32_t shift) {
    const std::size_t count = finals.cells.rows.size();
    if (finals.mesh_index.empty()) {
      least_.resize(shift + count);
      for (std::size_t c = 0; c < count; ++c) keep(shift + c, extremes(in_.cells[shift + c].vertices).first - 1, 0);
      return;
    }
    tile_.order.resize(count);
    placed_ = count;
    for (std::uint32_t c = 0; c < count; ++c) tile_.order[finals.mesh_index[c] - finals.early] = shift + c;
  }

  // Puts the other kept cells into buckets by their least vertex.
  void bucket_cells() {
    std::partial_sum(end_.begin(), end_.end(), end_.begin());
    tile_.order.resize(placed_ + end_.back());
    for (std::size_t c = 0; c < least_.size(); ++c) {
      const std::uint32_t least = least_[c] & ~mixed_row;
      if (least < own_) tile_.order[placed_ + end_[least]++] = static_cast<std::uint32_t>(c) | (least_[c] & mixed_row);
    }
    least_ = {};
  }

  void sort() {
    tile_.own = own_;
    tile_.index = std::move(index_);
    tile_.rows = std::move(in_.cells);
    const std::size_t before = tile_.early + placed_;
    mesh_.cell_ghost.resize(tile_.early + tile_.order.size());
    std::fill_n(mesh_.cell_ghost.begin(), before, std::uint8_t{0});
    tile_.mesh_index.resize(tile_.rows.size() + written_.size() + 2);
    std::int32_t* const mesh_index = tile_.mesh_index.data() + 2;
    for (std::size_t i = 0; i < placed_; ++i) mesh_index[tile_.order[i]] = static_cast<std::int32_t>(tile_.early + i);
    std::copy(written_.begin(), written_.end(), mesh_index + tile_.rows.size());
    SortedCells unsorted = tile_.sorted();
    unsorted.order = unsorted.order.subspan(placed_);
    sort_cells(d, unsorted,
               {.order = std::span(tile_.order).subspan(placed_),
                .first = static_cast<std::uint32_t>(before),
                .end = std::span(end_).first(own_),
                .owners = ranks_.empty() ? mesh_.owners : ranks_,
                .self = ranks_.empty() ? in_.self : rank_of(in_.self),
                .mesh_index = mesh_index,
                .ghost = mesh_.cell_ghost.data() + before},
               in_.stop);
  }

  static constexpr std::uint32_t unused = ~0u;
  CollectInput in_;
  const std::uint32_t own_ = static_cast<std::uint32_t>(in_.points.size());
  CollectedTile tile_;
  TileMesh& mesh_ = tile_.mesh;
  std::vector<std::uint32_t> others_;  // cells that are neither kept nor gaps
  std::vector<std::uint32_t> index_;   // by k: where foreign vertex k is in the mesh, or unused
  tsl::robin_map<CellKey, std::uint32_t, CellKeyHash> borders_;  // facet -> the kept cell across it, or across_outside
  BigVector<std::uint32_t> end_;                                 // by own vertex: see CellsToSort
  BigVector<std::uint32_t> least_;     // by cell: its least vertex | mixed_row, or why it is not kept
  std::size_t placed_ = 0;             // cells at the beginning of the order that need no sorting
  std::vector<TileId> ranks_;          // by vertex in the mesh: rank_of(its owner); empty when there are no images
  std::vector<std::int32_t> written_;  // numbers of early cells that are neighbours of kept cells
};

}  // namespace

CollectedTile collect_cells(CollectInput input) {
  return input.dimension == 3 ? Collector<3>(std::move(input)).make() : Collector<2>(std::move(input)).make();
}

}  // namespace tessera
