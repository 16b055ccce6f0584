#include "src/tiling/tile/early_finals.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "src/base/stopped.h"

namespace tessera {

namespace {

// Counts and places of one kind of cells, by their least vertex.
struct Buckets {
  // by own vertex, from the second entry on: how many cells have a lesser vertex; later, where the vertex's cells end
  BigVector<std::uint32_t> end;

  explicit Buckets(std::size_t own) : end(own + 1, 0) {}
  std::size_t count() const { return end.back(); }
};

constexpr std::uint32_t border = std::uint32_t{1} << 31;  // in `least`: the cell has a neighbour that is not final

template <int d>
void look_at(std::span<const CellRecord> rows, std::uint32_t* least, Buckets& inner, Buckets& outer) {
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const CellRecord& row = rows[r];
    std::uint32_t low = row.vertices[0], open = row.neighbors[0] == FinalCells::open;
    for (int i = 1; i <= d; ++i) {
      low = std::min(low, row.vertices[i]);
      open |= row.neighbors[i] == FinalCells::open;
    }
    least[r] = (low - 1) | (open ? border : 0);
    ++(open ? outer : inner).end[low];
  }
}

}  // namespace

EarlyFinals::EarlyFinals(int dimension, std::span<const PointId> ids, FinalCells cells, std::uint64_t unit,
                         const std::stop_token& stop)
    : dimension_(dimension), ids_(ids.begin(), ids.end()), cells_(std::move(cells)) {
  throw_if_stopped(stop);
  const std::span<const CellRecord> rows(cells_.rows.data(), cells_.rows.size());
  order_.resize(rows.size());
  mesh_index_.resize(rows.size() + 2);
  mesh_index_[0] = -2, mesh_index_[1] = -1;
  Buckets inner(ids.size()), outer(ids.size());
  BigVector<std::uint32_t> least(rows.size());
  dimension == 3 ? look_at<3>(rows, least.data(), inner, outer) : look_at<2>(rows, least.data(), inner, outer);
  for (Buckets* buckets : {&inner, &outer})
    std::partial_sum(buckets->end.begin(), buckets->end.end(), buckets->end.begin());
  const std::size_t known = inner.count();
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const std::uint32_t v = least[r] & ~border;
    const std::size_t at = (least[r] & border) != 0 ? known + outer.end[v]++ : inner.end[v]++;
    order_[at] = static_cast<std::uint32_t>(r);
  }
  least = {};
  const auto sort = [&](std::size_t first, std::size_t end, const Buckets& buckets) {
    sort_cells(dimension, sorted(first, end),
               {.order = std::span(order_).subspan(first, end - first),
                .first = static_cast<std::uint32_t>(first),
                .end = std::span(buckets.end).first(ids.size()),
                .owners = {},
                .self = {},
                .mesh_index = mesh_index_.data() + 2,
                .ghost = nullptr},
               stop);
  };
  sort(0, known, inner);
  sort(known, rows.size(), outer);
  early_ = known / unit * unit;
}

SortedCells EarlyFinals::sorted(std::size_t first, std::size_t end) const {
  return {.rows = {cells_.rows.data(), cells_.rows.size()},
          .order = std::span(order_).subspan(first, end - first),
          .index = {},
          .own = static_cast<std::uint32_t>(ids_.size()),
          .mesh_index = mesh_index_.data() + 2};
}

Status EarlyFinals::vertices(const Consumer& take) const {
  return stream_cells(dimension_, sorted(0, early_), copy_vertices, take);
}

Status EarlyFinals::neighbors(const Consumer& take) const {
  return stream_cells(dimension_, sorted(0, early_), copy_neighbors, take);
}

PendingFinals EarlyFinals::left() const {
  PendingFinals kept;
  kept.early = static_cast<std::uint32_t>(early_);
  kept.cells.others = cells_.others;
  const std::int32_t* const mesh_index = mesh_index_.data() + 2;
  const auto is_early = [&](std::uint32_t row) { return static_cast<std::uint64_t>(mesh_index[row]) < early_; };
  for (std::uint32_t row = 0; row < cells_.rows.size(); ++row) {
    if (is_early(row)) continue;
    kept.frozen.push_back(row);
    kept.mesh_index.push_back(static_cast<std::uint32_t>(mesh_index[row]));
  }
  BigVector<std::uint32_t> kept_row(cells_.rows.size());
  for (std::uint32_t k = 0; k < kept.frozen.size(); ++k) kept_row[kept.frozen[k]] = k;
  kept.cells.rows.reserve(kept.frozen.size());
  for (const std::uint32_t number : kept.frozen) {
    CellRecord row = cells_.rows[number];
    for (int i = 0; i <= dimension_; ++i) {
      std::uint32_t& n = row.neighbors[i];
      if (n == FinalCells::open) continue;
      n = is_early(n / 4) ? PendingFinals::written | static_cast<std::uint32_t>(mesh_index[n / 4])
                          : 4 * kept_row[n / 4] + n % 4;
    }
    kept.cells.rows.push_back(row);
  }
  return kept;
}

}  // namespace tessera
