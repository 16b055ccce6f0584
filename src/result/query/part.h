// Queries of a region: a result that has some cells of a triangulation, in one tile. These cells may not be connected,
// so a walk does not reach all of them. A tree of their boxes finds them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "src/base/point.h"
#include "src/result/query/batch.h"
#include "src/result/query/search.h"
#include "src/result/query/walker.h"

namespace tessera::query {

class CellTree {
 public:
  explicit CellTree(const QueryTile& tile);

  // Calls visit(cell) for every cell whose box meets the closed box `box`, and for some others.
  template <class Visit>
  void for_each_near(const Bounds& box, const Visit& visit) const {
    if (!levels_.empty()) descend(levels_.size() - 1, 0, box, visit);
  }

 private:
  static constexpr std::size_t leaf_cells = 8, branches = 4;

  static bool meet(const Bounds& a, const Bounds& b);
  template <class Visit>
  void descend(std::size_t level, std::size_t at, const Bounds& box, const Visit& visit) const {
    if (!meet(levels_[level][at], box)) return;
    const std::size_t width = level == 0 ? leaf_cells : branches;
    const std::size_t all = level == 0 ? order_.size() : levels_[level - 1].size();
    for (std::size_t i = at * width; i < std::min((at + 1) * width, all); ++i) {
      if (level == 0) {
        visit(order_[i]);
      } else {
        descend(level - 1, i, box, visit);
      }
    }
  }

  std::vector<std::int32_t> order_;          // cells, near ones together
  std::vector<std::vector<Bounds>> levels_;  // boxes of leaves, of their groups, ... of all
};

// Returns true if the result has all cells of the whole triangulation that meet the closed box. Also for results that
// are no regions.
bool knows(const Manifest& manifest, const Bounds& box);

// As Walker::locate(), as far as the region knows: no place if none of its cells contains q.
Located locate_in_part(const Manifest& manifest, const QueryTile& tile, const CellTree& tree, const Point& q);

// As locate_all().
Status locate_all_in_part(TileCache& cache, const Manifest& manifest, const CellTree& tree, const Batch& batch,
                          const VisitLocated& visit);

// As search().
Result<Found> search_part(Walker& walker, const Manifest& manifest, const CellTree& tree, const Area& area,
                          std::uint64_t cells_max, const std::stop_token& stop);

}  // namespace tessera::query
