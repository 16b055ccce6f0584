#include "src/result/volume/polygons.h"

#include <utility>

#include "src/result/query/map_polygons.h"

namespace tessera::volume {

namespace {

// A vertex has some two triangles, each with a place in the index, and stands in the geometry. The triangulation that
// makes them is gone when all are read.
constexpr std::uint64_t bytes_of_vertex = 600;

}  // namespace

Result<MapPolygons> read_polygons(const std::filesystem::path& path, const PolygonOptions& options) {
  MapPolygons read;
  const query::MapFileOptions file{.name = options.name,
                                   .heights = options.heights,
                                   .must_be_valid = true,
                                   .bytes_max = options.bytes_max,
                                   .bytes_of_vertex = bytes_of_vertex};
  BOOST_OUTCOME_TRY(
      frame, query::read_map_polygons(path, file, [&](query::MapFeature& feature) -> Status {
        std::vector<std::vector<Point>> rings;
        for (auto& polygon : feature.polygons) {
          for (auto& ring : polygon) rings.push_back(std::move(ring));
        }
        BOOST_OUTCOME_TRY(facets, triangulate_rings(rings));
        if (facets.empty()) return error(Errc::bad_input, "has no area");
        read.polygons.push_back({feature.number, std::move(feature.name), std::move(facets), std::move(feature.wkb)});
        return success();
      }));
  read.frame = std::move(frame);
  return read;
}

}  // namespace tessera::volume
