#include "src/result/tile_source.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>

#include "src/files/there.h"
#include "src/mesh/tile_mesh.h"
#include "src/result/check_sum.h"
#include "src/result/held_manifest.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

template <class Flags>
std::uint64_t count_zeros(const Flags& flags) {
  return static_cast<std::uint64_t>(std::count(flags.begin(), flags.end(), 0));
}

// The first thing in which the tile is another one than the manifest says; empty: none.
std::string difference(const Manifest& manifest, const TileEntry& entry, const StoredTile& tile, bool with_cells) {
  const TileMesh& mesh = tile.mesh;
  if (mesh.dimension != manifest.dimension) return "has another dimension than the manifest says";
  if (mesh.points.size() != entry.points || count_zeros(mesh.point_ghost) != entry.own_points ||
      (with_cells && (mesh.cell_ghost.size() != entry.cells || count_zeros(mesh.cell_ghost) != entry.main_cells)))
    return "holds other numbers of vertices or cells than the manifest says";
  if (with_cells && entry.cells > 0 && mesh.neighbors.empty() == manifest.neighbors)
    return manifest.neighbors ? "has no neighbours, though the manifest says so"
                              : "has neighbours, though the manifest says it has none";
  if (tile.schema != manifest.schema) return "has other attributes than the manifest says";
  if (tile.cell_schema != cell_schema_of(manifest)) return "has other columns of cells than the manifest says";
  return {};
}

}  // namespace

Result<TileSource> TileSource::open(const fs::path& out) {
  BOOST_OUTCOME_TRY(held, result::hold_manifest(out));
  return TileSource(std::make_shared<const Inside>(Inside{out, std::move(held.manifest), std::move(held.file)}));
}

std::optional<std::size_t> TileSource::find(TileId tile) const {
  const auto& all = manifest().tiles;
  const auto found = std::lower_bound(all.begin(), all.end(), tile,
                                      [](const TileEntry& entry, TileId wanted) { return entry.tile < wanted; });
  if (found == all.end() || found->tile != tile) return std::nullopt;
  return static_cast<std::size_t>(found - all.begin());
}

fs::path TileSource::file(TileId tile) const {
  const auto i = find(tile);
  return i ? file(*i) : tile_file(folder(), tile);
}

Status TileSource::check(std::size_t i) const {
  return check_sum(file(i), entry(i).xxh3, data_sum_of(manifest().format_version));
}

Result<StoredTile> TileSource::read(std::size_t i, const TileParts& parts) const {
  const auto path = file(i);
  BOOST_OUTCOME_TRY(tile, store::read_tile(path, entry(i).tile, parts));
  BOOST_OUTCOME_TRY(bytes, file_bytes(path));
  if (bytes != entry(i).bytes)
    return error(Errc::corrupt, path.string() + ": has " + std::to_string(bytes) + " bytes, the manifest says " +
                                    std::to_string(entry(i).bytes));
  if (const auto found = difference(manifest(), entry(i), tile, parts.cells); !found.empty())
    return error(Errc::corrupt, path.string() + ": " + found);
  return std::move(tile);
}

Result<std::vector<PointId>> TileSource::read_own_ids(std::size_t i) const {
  BOOST_OUTCOME_TRY(ids, store::read_own_ids(file(i), entry(i).tile));
  if (ids.size() != entry(i).own_points)
    return error(Errc::corrupt, file(i).string() + ": holds other numbers of vertices than the manifest says");
  return std::move(ids);
}

}  // namespace tessera
