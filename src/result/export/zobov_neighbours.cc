#include <algorithm>
#include <tuple>
#include <utility>
#include <vector>

#include "src/result/export/zobov.h"
#include "src/result/store/external_sort.h"

namespace tessera::exports {

namespace {

constexpr std::uint64_t pair_sort_bytes = std::uint64_t{256} << 20;
constexpr std::size_t pairs_at_once = std::size_t{1} << 20;

struct NeighbourPair {
  std::uint32_t of = 0, neighbour = 0;
  friend auto operator<=>(const NeighbourPair&, const NeighbourPair&) = default;
};

// Collects pairs of numbers. Most come several times, because an edge has several cells; a pair from cells that follow
// each other is passed on once.
class NeighbourPairs {
 public:
  NeighbourPairs(const MeshSource& source, const PointTable& table, const RowNumbers& rows,
                 const std::filesystem::path& scratch)
      : table_(table), rows_(rows), sorted_(scratch, pair_sort_bytes, source.stop) {}

  // A vertex and a neighbour, which may be an image of the vertex itself: that is no neighbour for ZOBOV.
  Status add(PointId of, PointId neighbour) {
    if (of == neighbour) return success();
    const auto here = table_.duplicates_of(of), there = table_.duplicates_of(neighbour);
    BOOST_OUTCOME_TRYV(add_pair(of, neighbour));
    for (const auto& pair : there) {
      BOOST_OUTCOME_TRYV(add_pair(of, pair.duplicate));
    }
    for (const auto& mine : here) {
      BOOST_OUTCOME_TRYV(add_pair(mine.duplicate, neighbour));
      for (const auto& pair : there) {
        BOOST_OUTCOME_TRYV(add_pair(mine.duplicate, pair.duplicate));
      }
    }
    return success();
  }
  // The points at the place of a vertex are neighbours of each other.
  Status add_place(PointId vertex) {
    const auto here = table_.duplicates_of(vertex);
    for (const auto& a : here) {
      BOOST_OUTCOME_TRYV(add_pair(vertex, a.duplicate));
      BOOST_OUTCOME_TRYV(add_pair(a.duplicate, vertex));
      for (const auto& b : here) {
        if (a.duplicate == b.duplicate) continue;
        BOOST_OUTCOME_TRYV(add_pair(a.duplicate, b.duplicate));
      }
    }
    return success();
  }
  template <class Visit>
  Status for_each(const Visit& visit) {
    BOOST_OUTCOME_TRYV(pass_on());
    NeighbourPair last{.of = ~std::uint32_t{0}, .neighbour = ~std::uint32_t{0}};
    return sorted_.for_each([&](const NeighbourPair& pair) -> Status {
      if (pair == last) return success();
      last = pair;
      return visit(pair);
    });
  }

 private:
  Status add_pair(PointId of, PointId neighbour) {
    if (!rows_.has(of) || !rows_.has(neighbour))
      return error(Errc::corrupt, "a cell of the result has a vertex that no tile owns");
    waiting_.push_back({.of = rows_.of(of), .neighbour = rows_.of(neighbour)});
    return waiting_.size() < pairs_at_once ? Status(success()) : pass_on();
  }
  Status pass_on() {
    std::sort(waiting_.begin(), waiting_.end());
    waiting_.erase(std::unique(waiting_.begin(), waiting_.end()), waiting_.end());
    for (const auto& pair : waiting_) {
      BOOST_OUTCOME_TRYV(sorted_.push(pair));
    }
    waiting_.clear();
    return success();
  }

  const PointTable& table_;
  const RowNumbers& rows_;
  std::vector<NeighbourPair> waiting_;
  ExternalSort<NeighbourPair> sorted_;
};

// Adds the pairs of a tile's own vertices: a tile has all cells around them.
Status add_tile(const TileMesh& mesh, NeighbourPairs& pairs) {
  const std::size_t corners = static_cast<std::size_t>(mesh.dimension) + 1;
  for (std::size_t at = 0; at < mesh.cells.size(); at += corners) {
    const auto vertex = [&](std::size_t k) { return static_cast<std::size_t>(mesh.cells[at + k]); };
    for (std::size_t k = 0; k < corners; ++k) {
      if (mesh.point_ghost[vertex(k)] != 0) continue;
      for (std::size_t i = 0; i < corners; ++i) {
        if (i == k) continue;
        BOOST_OUTCOME_TRYV(pairs.add(mesh.ids[vertex(k)], mesh.ids[vertex(i)]));
      }
    }
  }
  for (std::size_t i = 0; i < mesh.ids.size(); ++i) {
    if (mesh.point_ghost[i] != 0) continue;
    BOOST_OUTCOME_TRYV(pairs.add_place(mesh.ids[i]));
  }
  return success();
}

// Writes the numbers of neighbours to their places, and the lists behind them.
class NeighbourLists {
 public:
  NeighbourLists(const OutputFile& file, std::uint64_t points)
      : points_(points), counts_(file, 0), lists_(file, (points + 1) * sizeof(std::int32_t)) {
    counts_.value(static_cast<std::int32_t>(points));
  }
  Status add(const NeighbourPair& pair) {
    BOOST_OUTCOME_TRYV(end_before(pair.of));
    ++count_;
    if (pair.neighbour > pair.of) higher_.push_back(static_cast<std::int32_t>(pair.neighbour));
    return success();
  }
  Status finish() {
    BOOST_OUTCOME_TRYV(end_before(points_));
    BOOST_OUTCOME_TRYV(counts_.flush());
    return lists_.flush();
  }

 private:
  // Ends all points below `next`. jozov reads a length for each point, also where there are no neighbours.
  Status end_before(std::uint64_t next) {
    for (; point_ < next; ++point_) {
      counts_.value(count_);
      lists_.value(static_cast<std::int32_t>(higher_.size()));
      lists_.bytes(std::as_bytes(std::span(higher_)));
      count_ = 0;
      higher_.clear();
    }
    BOOST_OUTCOME_TRYV(counts_.status());
    return lists_.status();
  }
  std::uint64_t points_, point_ = 0;
  std::int32_t count_ = 0;
  std::vector<std::int32_t> higher_;
  Stream counts_, lists_;
};

}  // namespace

Status write_zobov_neighbours(const MeshSource& source, const PointTable& table, const RowNumbers& rows,
                              const OutputFile& file) {
  NeighbourPairs pairs(source, table, rows, folder_of(file.target()));
  const TileSource tiles = source.tiles->stopped_by(source.stop);
  for (std::size_t index = 0; index < tiles.tiles(); ++index) {
    if (source.stop.stop_requested()) return error(Errc::interrupted, "interrupted while exporting");
    if (source.options.progress)
      source.options.progress(static_cast<double>(index) / static_cast<double>(tiles.tiles()));
    BOOST_OUTCOME_TRY(tile, tiles.read(index, {.cells = true}));
    BOOST_OUTCOME_TRYV(add_tile(tile.mesh, pairs));
  }
  NeighbourLists lists(file, table.rows());
  BOOST_OUTCOME_TRYV(pairs.for_each([&](const NeighbourPair& pair) { return lists.add(pair); }));
  return lists.finish();
}

}  // namespace tessera::exports
