#include "src/query/geojson.h"

#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "src/files/whole_file.h"

namespace tessera::query {
namespace {

using nlohmann::json;

constexpr int depth_max = 16;  // of collections in collections

// Collects the rings of all polygons in a document, or its lines. Errors are the end of a sentence: "features[3]: ...".
class Collection {
 public:
  explicit Collection(GeoJson kind)
      : polygons_(kind == GeoJson::polygons), single_(polygons_ ? "Polygon" : "LineString") {}

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
    if ((*type == single_ || *type == "Multi" + single_) && coordinates != object.end() && coordinates->is_array()) {
      const std::string at = place + ".coordinates";
      if (*type == single_) return add_one(*coordinates, at);
      for (std::size_t i = 0; i < coordinates->size(); ++i) {
        BOOST_OUTCOME_TRYV(add_one((*coordinates)[i], at + "[" + std::to_string(i) + "]"));
      }
      return success();
    }
    return bad(place, "is neither " + single_ + " nor Multi" + single_ + ", nor a collection of them");
  }
  std::vector<std::vector<Point>> take() { return std::move(found_); }

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

  Status add_one(const json& one, const std::string& place) {
    if (!polygons_) {
      BOOST_OUTCOME_TRY(line, positions(one, place, "is no line"));
      if (line.size() < 2) return bad(place, "has fewer than two positions");
      found_.push_back(std::move(line));
      return success();
    }
    if (!one.is_array()) return bad(place, "is no list of rings");
    for (std::size_t r = 0; r < one.size(); ++r) {
      const std::string at = place + "[" + std::to_string(r) + "]";
      BOOST_OUTCOME_TRY(ring, positions(one[r], at, "is no ring"));
      if (ring.size() > 1 && ring.front() == ring.back()) ring.pop_back();
      if (ring.size() < 3) return bad(at, "has fewer than three different positions");
      found_.push_back(std::move(ring));
    }
    return success();
  }

  static Result<std::vector<Point>> positions(const json& list, const std::string& place, const char* no_list) {
    if (!list.is_array()) return bad(place, no_list);
    std::vector<Point> points;
    for (std::size_t i = 0; i < list.size(); ++i) {
      const json& p = list[i];
      if (!p.is_array() || p.size() < 2 || !p[0].is_number() || !p[1].is_number() ||
          !is_finite({p[0].get<double>(), p[1].get<double>(), 0}))
        return bad(place + "[" + std::to_string(i) + "]", "is no position");
      points.push_back(without_negative_zero({p[0].get<double>(), p[1].get<double>(), 0}));
    }
    return points;
  }

  bool polygons_;
  std::string single_;
  std::vector<std::vector<Point>> found_;
};

}  // namespace

Result<std::vector<std::vector<Point>>> read_geojson(const std::filesystem::path& path, GeoJson kind) {
  BOOST_OUTCOME_TRY(text, read_whole(path));
  return of_geojson(as_text(text), path.string(), kind);
}

Result<std::vector<std::vector<Point>>> of_geojson(std::string_view text, const std::string& name, GeoJson kind) {
  const json document = json::parse(text, nullptr, false);
  const auto bad = [&](const std::string& reason) { return error(Errc::bad_input, name + ": " + reason); };
  if (document.is_discarded()) return bad("is not JSON");
  Collection collection(kind);
  if (auto added = collection.add(document, ""); !added) return bad(added.error().where);
  auto found = collection.take();
  if (found.empty()) return bad(kind == GeoJson::polygons ? "has no polygon" : "has no line");
  return found;
}

}  // namespace tessera::query
