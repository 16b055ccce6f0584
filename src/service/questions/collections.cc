#include "src/service/questions/collections.h"

#include "src/base/crs/lon_lat.h"
#include "src/base/crs/storage_crs.h"
#include "src/base/files/names.h"
#include "src/result/terrain/line_reader.h"
#include "src/result/terrain/map_tile.h"
#include "src/service/beneath.h"
#include "src/service/naming.h"
#include "src/service/problem.h"

namespace tessera::service {
namespace {

constexpr std::size_t places_max = 4096;
constexpr const char* kinds[] = {"tiles", "hull", "contours"};

proto::Problem nothing(std::string_view id) {
  return problem(404, "there is no collection '" + std::string(id) + "'", Errc::usage);
}

}  // namespace

std::optional<Collections::Place> Collections::place_of(const ResultFolders::Held& held) {
  {
    const std::lock_guard lock(mutex_);
    if (const auto known = places_.find(held.identity); known != places_.end()) return known->second;
  }
  const Manifest& manifest = *held.manifest;
  std::optional<Place> place;
  const auto places = LonLat::of(manifest.crs);
  if (places && !manifest.bounds.empty()) {
    if (const auto box = places.value().box_to(manifest.bounds))
      place = Place{{box.value().lo.x, box.value().lo.y, box.value().hi.x, box.value().hi.y}, {}};
    if (const auto storage = storage_crs(manifest.crs); place && storage) place->storage_crs = storage.value().uri;
  }
  // There is no GDAL now, but there may be later.
  if (!places && places.error().code == Errc::io) return place;
  const std::lock_guard lock(mutex_);
  if (places_.size() >= places_max) places_.clear();
  places_[held.identity] = place;
  return place;
}

Result<std::optional<FeatureCollection>> Collections::make(const std::string& name, const std::string& kind,
                                                           const ResultFolders::Held& held) {
  const std::optional<FeatureCollection> none;
  const auto place = place_of(held);
  if (!place) return none;
  if (kind == "contours") {
    BOOST_OUTCOME_TRY(there, results_.export_exists(name, contours_of_result("").filename().string()));
    if (!there) return none;
    const auto lines = terrain::LineReader::open(contours_of_result(path_of(held.folder)));
    if (!lines && lines.error().code == Errc::io) return lines.error();
    if (!lines) return none;
  }
  FeatureCollection made{.id = name + "." + kind,
                         .triangulation = name,
                         .kind = kind,
                         .extent = place->extent,
                         .storage_crs = place->storage_crs};
  made.title = name + (kind == "tiles" ? ": tiles" : kind == "hull" ? ": hull" : ": contour lines");
  made.description = kind == "tiles"  ? "The areas that the tiles of the triangulation " + name + " cover"
                     : kind == "hull" ? "The convex hull of the points of the triangulation " + name + ", in the plane"
                                      : "The contour lines of the surface of the triangulation " + name;
  return std::optional(std::move(made));
}

Reply<std::vector<FeatureCollection>> Collections::list() {
  std::vector<FeatureCollection> all;
  const auto names = results_.names();
  if (!names) return problem_of(names.error());
  for (const auto& name : names.value()) {
    // The result is gone, damaged or unreadable. It must not hide the others; find() reports why.
    const auto held = results_.hold(name);
    if (!held) continue;
    for (const char* kind : kinds)
      if (auto made = make(name, kind, held.value()); made && made.value()) all.push_back(*std::move(made).value());
  }
  return all;
}

Reply<FeatureCollection> Collections::find(std::string_view id) {
  const auto dot = id.rfind('.');
  if (dot == std::string_view::npos) return nothing(id);
  const std::string name(id.substr(0, dot)), kind(id.substr(dot + 1));
  bool known = false;
  for (const char* one : kinds) known = known || kind == one;
  if (!known) return nothing(id);
  const auto held = results_.find(name);
  if (!held) return problem_of(held.error());
  if (!held.value()) return nothing(id);
  auto made = make(name, kind, *held.value());
  if (!made) return problem_of(made.error());
  return made.value() ? Reply<FeatureCollection>(*std::move(made).value()) : nothing(id);
}

Reply<std::array<double, 4>> Collections::map_extent(std::string_view name) {
  const auto missing = [&] {
    return problem(404,
                   "triangulation '" + std::string(name) +
                       "' has no map: the process dem makes one from the heights when its output is called " +
                       dem_of_result("").filename().string() + " and the result has a coordinate system",
                   Errc::usage);
  };
  const auto held = results_.find(name);
  if (!held) return problem_of(held.error());
  if (!held.value()) return problem(404, "there is no triangulation '" + std::string(name) + "'", Errc::usage);
  const auto drawn = results_.export_exists(name, dem_of_result("").filename().string());
  if (!drawn) return problem_of(drawn.error());
  if (!drawn.value()) return missing();
  const auto raster = terrain::HeightRaster::open(dem_of_result(path_of(held.value()->folder)));
  if (!raster) return raster.error().code == Errc::usage ? missing() : problem_of(raster.error());
  return raster.value()->extent();
}

}  // namespace tessera::service
