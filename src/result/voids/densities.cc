#include "src/result/voids/densities.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "src/base/option.h"
#include "src/result/query/column.h"

namespace tessera::voids {

std::string Densities::volume_column(int dimension) { return dimension == 2 ? "voronoi_area" : "voronoi_volume"; }

bool Densities::has_column(const Manifest& manifest, const std::string& name) {
  return std::ranges::any_of(manifest.columns,
                             [&](const ResultColumn& one) { return !one.of_cells && one.name == name; });
}

Result<Densities> Densities::open(const TileSource& source, const std::string& by, std::uint64_t memory_bytes) {
  const Manifest& manifest = source.manifest();
  Densities densities;
  densities.by_volume_ = by == "voronoi";
  densities.name_ = densities.by_volume_ ? volume_column(manifest.dimension) : by;
  densities.row_bytes_ = row_bytes(manifest.schema);
  const std::string volume = volume_column(manifest.dimension);
  for (const std::string& name : {volume, densities.name_}) {
    if (!has_column(manifest, name))
      return error(Errc::usage, source.folder().string() + ": has no column '" + name +
                                    "' of its vertices; the measures " + option("voronoi", "true") + " and " +
                                    option("density", "true") + " compute such columns");
  }
  BOOST_OUTCOME_TRY(of_volume, query::find_column(source.folder(), manifest, volume));
  BOOST_OUTCOME_TRY(of_density, query::find_column(source.folder(), manifest, densities.name_));
  densities.volume_ = of_volume;
  densities.density_ = of_density;
  BOOST_OUTCOME_TRY(points, VertexMasses::open(source, "", memory_bytes));
  densities.points_ = std::move(points);
  return densities;
}

Result<TileDensities> Densities::of(const TileSource& source, std::size_t index, const StoredTile& tile) const {
  const TileMesh& mesh = tile.mesh;
  TileDensities made;
  made.levels.resize(mesh.ids.size());
  made.volumes.resize(mesh.ids.size());
  BOOST_OUTCOME_TRY(points, points_.of(source, index, mesh));
  made.points = std::move(points);
  for (std::size_t v = 0; v < mesh.ids.size(); ++v) {
    const std::byte* row = &tile.rows[v * row_bytes_];
    const double volume = volume_.value(row), value = by_volume_ ? -volume : density_.value(row);
    if (!(volume >= 0))
      return error(Errc::corrupt, source.file(index).string() + ": the Voronoi cell of vertex " +
                                      to_string(mesh.ids[v]) + " has the size " + std::to_string(volume));
    if (!by_volume_ && !(value >= 0))
      return error(Errc::bad_input, source.folder().string() + ": the column '" + name_ + "' of vertex " +
                                        to_string(mesh.ids[v]) + " is " + std::to_string(value) +
                                        ", but a density must not be negative");
    const bool outside = std::isinf(volume);
    made.levels[v] = outside ? std::numeric_limits<double>::quiet_NaN() : value;
    if (mesh.point_ghost[v] == 0 && !outside) made.volumes[v] = volume;
  }
  return made;
}

}  // namespace tessera::voids
