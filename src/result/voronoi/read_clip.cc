#include "src/result/voronoi/read_clip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>

#include "src/base/crs/crs.h"
#include "src/base/ledger.h"
#include "src/base/option.h"
#include "src/result/export/ending.h"
#include "src/result/query/geojson.h"
#include "src/result/query/hull.h"
#include "src/result/query/map_polygons.h"

namespace tessera::voronoi {

namespace fs = std::filesystem;

namespace {

// Adds polygons to a region, within the memory of the ledger.
class RegionMaker {
 public:
  Status add(std::span<const std::vector<Point>> rings) {
    std::uint64_t edges = 0;
    for (const auto& ring : rings) edges += ring.size();
    edges_ += edges;
    if (edges_ >= edges_max)
      return error(Errc::memory, "the polygons have more than " + std::to_string(edges_max) + " edges");
    BOOST_OUTCOME_TRYV(Ledger::draw_memory(edges * ClipRegion::bytes_of_edge));
    region_.add(rings);
    return success();
  }
  ClipRegion finish() {
    region_.index();
    return std::move(region_);
  }

 private:
  static constexpr std::uint64_t edges_max = std::uint64_t{1} << 28;
  ClipRegion region_;
  std::uint64_t edges_ = 0;
};

Result<ClipRegion> map_region(const fs::path& path, const Manifest& manifest) {
  RegionMaker maker;
  BOOST_OUTCOME_TRY(frame, query::read_map_polygons(path, {}, [&](query::MapFeature& feature) -> Status {
                      for (const auto& rings : feature.polygons) {
                        BOOST_OUTCOME_TRYV(maker.add(rings));
                      }
                      return success();
                    }));
  if (surely_other_crs(frame.crs, manifest.crs))
    return error(Errc::bad_input, path.string() + ": its coordinates are those of " + crs_title(frame.crs) +
                                      ", and the points have those of " + crs_title(manifest.crs) +
                                      "; transform it first, as ogr2ogr -t_srs does");
  return maker.finish();
}

Result<ClipRegion> geojson_region(const fs::path& path, const Manifest& manifest) {
  BOOST_OUTCOME_TRY(shapes, query::read_geojson(path, query::GeoJson::polygons));
  BOOST_OUTCOME_TRYV(shapes.place.check_in(manifest.crs, manifest.bounds));
  RegionMaker maker;
  const std::span<const std::vector<Point>> rings = shapes.lists;
  for (std::size_t i = 0; i < shapes.firsts.size(); ++i) {
    const std::size_t end = i + 1 < shapes.firsts.size() ? shapes.firsts[i + 1] : rings.size();
    BOOST_OUTCOME_TRYV(maker.add(rings.subspan(shapes.firsts[i], end - shapes.firsts[i])));
  }
  return maker.finish();
}

}  // namespace

Result<ClipRegion> hull_region(const TileSource& source, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(hull, query::hull_of(source, stop));
  ClipRegion region;
  region.set_convex();
  region.add(std::span(&hull, 1));
  region.index();
  return region;
}

Result<ClipRegion> box_region(const Bounds& box) {
  const auto is_finite = [](const Point& p) { return std::isfinite(p.x) && std::isfinite(p.y); };
  if (!is_finite(box.lo) || !is_finite(box.hi) || !(box.lo.x < box.hi.x) || !(box.lo.y < box.hi.y))
    return error(Errc::usage, option("clip") + ": the box has no area; each side needs two different finite numbers");
  const std::vector<Point> ring{
      {box.lo.x, box.lo.y, 0}, {box.hi.x, box.lo.y, 0}, {box.hi.x, box.hi.y, 0}, {box.lo.x, box.hi.y, 0}};
  ClipRegion region;
  region.set_convex();
  region.add(std::span(&ring, 1));
  region.index();
  return region;
}

bool is_region_file(const fs::path& path) {
  constexpr std::array<std::string_view, 5> endings{".gpkg", ".fgb", ".shp", ".geojson", ".json"};
  return std::find(endings.begin(), endings.end(), exports::ending_of(path)) != endings.end();
}

Result<ClipRegion> file_region(const fs::path& path, const Manifest& manifest) {
  const std::string ending = exports::ending_of(path);
  if (ending == ".gpkg" || ending == ".fgb" || ending == ".shp") return map_region(path, manifest);
  if (ending == ".geojson" || ending == ".json") return geojson_region(path, manifest);
  return error(Errc::usage, path.string() + ": is no file of polygons by its ending, .gpkg, .fgb, .shp or .geojson");
}

}  // namespace tessera::voronoi
