#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "src/files/whole_file.h"
#include "src/query/area.h"

namespace tessera::query {
namespace {

using nlohmann::json;

constexpr int depth_max = 16;  // of collections in collections

// Collects the rings of all polygons in a document. Errors are the end of a sentence: "features[3]: ...".
class Rings {
 public:
  // `place` is where `object` stands.
  Status add(const json& object, const std::string& place, int depth = 0) {
    if (depth > depth_max) return bad(place, "is too deep inside other collections");
    const auto type = object.is_object() ? object.find("type") : object.end();
    if (!object.is_object() || type == object.end() || !type->is_string()) return bad(place, "is no GeoJSON object");
    if (*type == "FeatureCollection") return add_each(object, "features", place, depth);
    if (*type == "GeometryCollection") return add_each(object, "geometries", place, depth);
    if (*type == "Feature") {
      const auto geometry = object.find("geometry");
      return geometry == object.end() ? bad(place, "has no geometry") : add(*geometry, place + ".geometry", depth + 1);
    }
    const auto coordinates = object.find("coordinates");
    if ((*type == "Polygon" || *type == "MultiPolygon") && coordinates != object.end() && coordinates->is_array()) {
      const std::string at = place + ".coordinates";
      if (*type == "Polygon") return add_polygon(*coordinates, at);
      for (std::size_t i = 0; i < coordinates->size(); ++i) {
        BOOST_OUTCOME_TRYV(add_polygon((*coordinates)[i], at + "[" + std::to_string(i) + "]"));
      }
      return success();
    }
    return bad(place, "is neither Polygon nor MultiPolygon, nor a collection of them");
  }
  std::vector<std::vector<Point>> take() { return std::move(rings_); }

 private:
  static Error bad(const std::string& place, const std::string& reason) {
    return error(Errc::bad_input, (place.empty() ? "it" : place.substr(place[0] == '.' ? 1 : 0)) + " " + reason);
  }

  Status add_each(const json& object, const char* key, const std::string& place, int depth) {
    const auto list = object.find(key);
    if (list == object.end() || !list->is_array()) return bad(place, std::string("has no list of ") + key);
    for (std::size_t i = 0; i < list->size(); ++i) {
      BOOST_OUTCOME_TRYV(add((*list)[i], place + "." + key + "[" + std::to_string(i) + "]", depth + 1));
    }
    return success();
  }

  Status add_polygon(const json& polygon, const std::string& place) {
    if (!polygon.is_array()) return bad(place, "is no list of rings");
    for (std::size_t r = 0; r < polygon.size(); ++r) {
      const std::string at = place + "[" + std::to_string(r) + "]";
      if (!polygon[r].is_array()) return bad(at, "is no ring");
      std::vector<Point> ring;
      for (std::size_t i = 0; i < polygon[r].size(); ++i) {
        const json& p = polygon[r][i];
        if (!p.is_array() || p.size() < 2 || !p[0].is_number() || !p[1].is_number() ||
            !is_finite({p[0].get<double>(), p[1].get<double>(), 0}))
          return bad(at + "[" + std::to_string(i) + "]", "is no position");
        ring.push_back(without_negative_zero({p[0].get<double>(), p[1].get<double>(), 0}));
      }
      if (ring.size() > 1 && ring.front() == ring.back()) ring.pop_back();
      if (ring.size() < 3) return bad(at, "has fewer than three different positions");
      rings_.push_back(std::move(ring));
    }
    return success();
  }

  std::vector<std::vector<Point>> rings_;
};

}  // namespace

Result<Polygon> Polygon::read_geojson(const std::filesystem::path& path) {
  BOOST_OUTCOME_TRY(text, read_whole(path));
  return of_geojson(as_text(text), path.string());
}

Result<Polygon> Polygon::of_geojson(std::string_view text, const std::string& name) {
  const json document = json::parse(text, nullptr, false);
  const auto bad = [&](const std::string& reason) { return error(Errc::bad_input, name + ": " + reason); };
  if (document.is_discarded()) return bad("is not JSON");
  Rings rings;
  if (auto added = rings.add(document, ""); !added) return bad(added.error().where);
  auto found = rings.take();
  if (found.empty()) return bad("has no polygon");
  return Polygon(std::move(found));
}

}  // namespace tessera::query
