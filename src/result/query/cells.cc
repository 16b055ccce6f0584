#include "src/result/query/cells.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "src/base/option.h"
#include "src/result/export/cell_filter.h"
#include "src/result/query/opened_result.h"
#include "src/result/query/search.h"
#include "src/result/verify/match_facets.h"

namespace tessera::query {
namespace {

// Copies cells out of tiles, and each of their vertices once.
class Collector {
 public:
  Collector(const Manifest& manifest, std::size_t cells) : row_bytes_(tessera::row_bytes(manifest.schema)) {
    set_.mesh.mesh.dimension = manifest.dimension;
    set_.mesh.schema = manifest.schema;
    set_.tiles.reserve(cells);
  }

  void add(const QueryTile& tile, std::int32_t cell) {
    TileMesh& mesh = set_.mesh.mesh;
    for (std::size_t k = 0; k < tile.corners(); ++k) {
      const std::int32_t v = tile.vertex(cell, k);
      const auto [at, is_new] = numbers_.emplace(tile.id_of(v).value, static_cast<std::int32_t>(mesh.points.size()));
      mesh.cells.push_back(at->second);
      if (!is_new) continue;
      mesh.points.push_back(tile.point(v));
      mesh.ids.push_back(tile.id_of(v));
      mesh.owners.push_back(tile.owner(v));
      mesh.point_ghost.push_back(0);
      if (row_bytes_ > 0) set_.mesh.rows.insert(set_.mesh.rows.end(), tile.row(v), tile.row(v) + row_bytes_);
    }
    mesh.cell_ghost.push_back(0);
    if (!tile.mesh().cell_final.empty()) mesh.cell_final.push_back(tile.is_final(cell) ? 1 : 0);
    set_.tiles.push_back(tile.id());
    set_.places.push_back(cell);
  }
  CellSet take() { return std::move(set_); }

 private:
  std::size_t row_bytes_;
  CellSet set_;
  std::unordered_map<std::uint64_t, std::int32_t> numbers_;  // by source index
};

// The lowest tile that owns a vertex of the facet opposite corner k.
TileId first_owner(const QueryTile& tile, std::int32_t cell, std::size_t k) {
  TileId first = tile.owner(tile.vertex(cell, k == 0 ? 1 : 0));
  for (std::size_t i = 1; i < tile.corners(); ++i)
    if (i != k) first = std::min(first, tile.owner(tile.vertex(cell, i)));
  return first;
}

// The bit of the facet opposite corner k, in the order of corners that the cell has in its main tile.
unsigned facet_bit(const QueryTile& main, std::int32_t main_cell, const QueryTile& tile, std::int32_t cell,
                   std::size_t k) {
  const PointId opposite = tile.id_of(tile.vertex(cell, k));
  for (std::size_t i = 0; i < main.corners(); ++i)
    if (main.id_of(main.vertex(main_cell, i)) == opposite) return 1u << i;
  return 0;
}

// Counts cells by their longest edge, in steps of a thirty-second of an octave, so the memory does not depend on the
// number of cells.
class Lengths {
 public:
  void add(double length) {
    if (length > 0 && std::isfinite(length)) ++steps_[static_cast<int>(std::ceil(std::log2(length) * steps_of_octave))];
  }
  // The percentiles of the lengths, ascending.
  std::vector<double> parts() const {
    std::uint64_t all = 0, before = 0;
    for (const auto& [step, count] : steps_) all += count;
    std::vector<double> parts;
    for (const auto& [step, count] : steps_) {
      before += count;
      while (parts.size() <= 100 && before * 100 >= all * parts.size())
        parts.push_back(std::exp2(step / steps_of_octave));
    }
    return parts;
  }

 private:
  static constexpr double steps_of_octave = 32;
  std::map<int, std::uint64_t> steps_;
};

// For each cell of a tile, true if it is within the limits. Counts the main cells.
std::vector<bool> kept_of(const QueryTile& tile, const exports::CellFilter& filter, Lengths& lengths) {
  const TileMesh& mesh = tile.mesh();
  std::vector<bool> kept(mesh.cell_ghost.size());
  for (std::size_t cell = 0; cell < kept.size(); ++cell) {
    kept[cell] = filter.fits(mesh, cell);
    if (mesh.cell_ghost[cell] == 0) lengths.add(exports::longest_edge(mesh, cell));
  }
  return kept;
}

// The number of cells that an answer may have.
struct AnswerBudget {
  AnswerBudget(const CellLimits& limits, const Manifest& manifest)
      : limits(limits),
        // A cell with its corners, neighbours and tile, and with at most about one vertex with its attributes.
        fit(limits.bytes_max / (68 + sizeof(Point) + 40 + tessera::row_bytes(manifest.schema))),
        most(std::min(limits.cells_max, fit)) {}

  Error exceeded(const std::filesystem::path& out, const std::string& what) const {
    const std::string begin = out.string() + ": " + what + " has more than ";
    if (limits.cells_max < fit)
      return error(Errc::memory,
                   begin + std::to_string(limits.cells_max) + " cells, which is the limit: give a smaller area");
    return error(Errc::memory, begin + std::to_string(fit) + " cells, which take " +
                                   std::to_string(limits.bytes_max >> 20) + " MiB of memory: give more " +
                                   option("memory") + ", or a smaller area");
  }

  const CellLimits& limits;
  std::uint64_t fit, most;
};

}  // namespace

Result<CellSet> cells_of(const OpenedResult& result, const Area& area, const CellLimits& limits,
                         const AskOptions& options) {
  BOOST_OUTCOME_TRYV(result.refuse_periods("questions for the cells of an area"));
  const Manifest& manifest = result.manifest;
  if (area.plane && manifest.dimension != 3)
    return error(Errc::usage, result.out.string() + ": is a 2D result, which no plane of space cuts");
  const AnswerBudget budget(limits, manifest);
  Walker walker(result.cache, manifest, !manifest.schema.empty());
  BOOST_OUTCOME_TRY(found, result.find(walker, area, budget.most, options.stop));
  if (found.count > budget.most) return budget.exceeded(result.out, area.plane ? "the section" : "the area");
  Collector collector(manifest, found.count);
  for (auto& [id, cells] : found.cells) {
    walker.keep_only(nullptr);
    BOOST_OUTCOME_TRY(tile, walker.tile(id));
    std::sort(cells.begin(), cells.end());
    for (const std::int32_t cell : cells) collector.add(*tile, cell);
  }
  CellSet set = collector.take();
  set.final = knows(manifest, area.box);
  BOOST_OUTCOME_TRYV(match_facets(set.mesh.mesh, result.out));
  return set;
}

Result<HullCells> hull_of(const OpenedResult& result, const CellLimits& limits, const AskOptions& options,
                          std::optional<double> max_edge, std::optional<double> max_radius) {
  BOOST_OUTCOME_TRYV(result.refuse_periods("questions for the hull"));
  const Manifest& manifest = result.manifest;
  const AnswerBudget budget(limits, manifest);
  Walker walker(result.cache, manifest, !manifest.schema.empty());
  std::map<TileId, std::map<std::int32_t, std::uint8_t>> found;  // bits of facets, by main tile and index
  std::uint64_t count = 0;
  Lengths lengths;
  for (const TileEntry& entry : manifest.tiles) {
    if (options.stop.stop_requested()) return error(Errc::interrupted, "interrupted while looking for the hull");
    walker.keep_only(nullptr);
    BOOST_OUTCOME_TRY(tile, walker.tile(entry.tile));
    const std::vector<bool> kept = kept_of(*tile, exports::CellFilter({max_edge, max_radius}), lengths);
    for (std::int32_t cell = 0; cell < static_cast<std::int32_t>(kept.size()); ++cell) {
      if (!kept[static_cast<std::size_t>(cell)]) continue;
      for (std::size_t k = 0; k < tile->corners(); ++k) {
        const std::int32_t beyond = tile->neighbor(cell, k);
        if (beyond >= 0 && kept[static_cast<std::size_t>(beyond)]) continue;
        // A tile knows what is beyond a facet when it owns a vertex of the facet. Of several such tiles the lowest
        // reports it.
        if (first_owner(*tile, cell, k) != tile->id()) continue;
        BOOST_OUTCOME_TRY(main, walker.main_place({tile, cell}));
        auto& facets = found[main.tile->id()][main.cell];
        count += facets == 0 ? 1 : 0;
        facets = static_cast<std::uint8_t>(facets | facet_bit(*main.tile, main.cell, *tile, cell, k));
        if (main.tile != tile) walker.keep_only(tile);
        if (count > budget.most) return budget.exceeded(result.out, "the hull");
      }
    }
  }
  Collector collector(manifest, count);
  HullCells hull;
  for (const auto& [id, cells] : found) {
    walker.keep_only(nullptr);
    BOOST_OUTCOME_TRY(tile, walker.tile(id));
    for (const auto& [cell, facets] : cells) {
      collector.add(*tile, cell);
      hull.facets.push_back(facets);
    }
  }
  hull.set = collector.take();
  hull.lengths = lengths.parts();
  hull.set.final = !manifest.region;
  return hull;
}

Result<Cell> cell_of(const OpenedResult& result, TileId id, std::int32_t place) {
  const auto& tiles = result.manifest.tiles;
  const auto is_it = [&](const TileEntry& entry) { return entry.tile == id; };
  if (std::none_of(tiles.begin(), tiles.end(), is_it))
    return error(Errc::usage, result.out.string() + ": has no tile " + to_string(id));
  Walker walker(result.cache, result.manifest, false);
  BOOST_OUTCOME_TRY(tile, walker.tile(id));
  const auto& ghost = tile->mesh().cell_ghost;
  if (place < 0 || static_cast<std::size_t>(place) >= ghost.size() || ghost[static_cast<std::size_t>(place)] != 0)
    return error(Errc::usage,
                 result.out.string() + ": tile " + to_string(id) + " has no main cell " + std::to_string(place));
  Cell cell = cell_at({tile, place});
  cell.final = tile->is_final(place);
  return cell;
}

Result<std::vector<TileId>> tiles_of(const OpenedResult& result, const Area& area, const AskOptions& options) {
  BOOST_OUTCOME_TRYV(result.refuse_periods("questions for the tiles of an area"));
  Walker walker(result.cache, result.manifest, false);
  BOOST_OUTCOME_TRY(found, result.find(walker, area, ~std::uint64_t{0}, options.stop));
  return std::vector<TileId>(found.owners.begin(), found.owners.end());
}

}  // namespace tessera::query
