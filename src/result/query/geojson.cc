#include "src/result/query/geojson.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "src/base/crs/crs.h"
#include "src/base/files/whole_file.h"
#include "src/base/json/json_text.h"

namespace tessera::query {
namespace {

using nlohmann::json;

constexpr int depth_max = 16;  // of collections in collections

// Collects the rings of all polygons in a document, or its lines. Errors are the end of a sentence: "features[3]: ...".
class Collection {
 public:
  explicit Collection(GeoJson kind)
      : polygons_(kind == GeoJson::polygons), single_(polygons_ ? "Polygon" : "LineString") {}

  // `place` names the position of `object` in the document.
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
  std::vector<std::size_t> take_firsts() { return std::move(firsts_); }

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
    firsts_.push_back(found_.size());
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
  std::vector<std::size_t> firsts_;
};

// The name in the member `crs` of the specification of 2008, which GDAL and QGIS still write. Empty when there is no
// name.
std::string named_crs(const json& document) {
  const auto crs = document.find("crs");
  if (crs == document.end() || !crs->is_object()) return {};
  const auto properties = crs->find("properties");
  if (properties == crs->end() || !properties->is_object()) return {};
  const auto name = properties->find("name");
  return name != properties->end() && name->is_string() ? crs_of_name(name->get<std::string>()) : "";
}

// GDAL compares names of members without regard to case.
bool is_called(const std::string& name, std::string_view wanted) {
  return std::equal(name.begin(), name.end(), wanted.begin(), wanted.end(),
                    [](char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == b; });
}

// Looks through a document for members `crs` that are neither a name nor an EPSG code.
class CrsLinks final : public nlohmann::json_sax<json> {
 public:
  bool found() const { return found_; }

  bool null() override { return value(); }
  bool boolean(bool /*value*/) override { return value(); }
  bool number_integer(number_integer_t /*value*/) override { return value(); }
  bool number_unsigned(number_unsigned_t /*value*/) override { return value(); }
  bool number_float(number_float_t /*value*/, const string_t& /*text*/) override { return value(); }
  bool binary(binary_t& /*value*/) override { return value(); }
  bool string(string_t& text) override {
    found_ = found_ || (at_type_ && !is_called(text, "name") && !is_called(text, "epsg"));
    return value();
  }
  bool key(string_t& name) override {
    at_type_ = depth_ > 0 && depth_ == crs_depth_ && is_called(name, "type");
    at_crs_ = crs_depth_ == 0 && is_called(name, "crs");
    return true;
  }
  bool start_object(std::size_t /*size*/) override {
    ++depth_;
    if (at_crs_) crs_depth_ = depth_;
    return value();
  }
  bool end_object() override {
    if (depth_ == crs_depth_) crs_depth_ = 0;
    --depth_;
    return true;
  }
  bool start_array(std::size_t /*size*/) override { return value(); }
  bool end_array() override { return true; }
  bool parse_error(std::size_t /*at*/, const std::string& /*token*/, const json::exception& /*why*/) override {
    return false;
  }

 private:
  bool value() {
    at_type_ = at_crs_ = false;
    return true;
  }

  std::size_t depth_ = 0, crs_depth_ = 0;  // of the object that is the value of `crs`; 0: none is open
  bool at_type_ = false, at_crs_ = false;  // the next value is that of such a member
  bool found_ = false;
};

}  // namespace

Status check_no_links(const std::filesystem::path& path) {
  BOOST_OUTCOME_TRY(text, read_whole(path));
  CrsLinks links;
  const auto bad = [&](const char* reason) { return error(Errc::bad_input, path.string() + ": " + reason); };
  if (!json::sax_parse(as_text(text), &links)) return bad("is not JSON");
  if (links.found()) return bad("gives its coordinate system as a link, which is not followed; give its name instead");
  return success();
}

Status GeoJsonFrame::check_in(const std::string& there, const Bounds& points) const {
  const auto refuse = [&](const std::string& why) {
    const std::string code = crs_code(there);
    return error(Errc::bad_input, name + ": " + why + "; transform it first, as ogr2ogr -t_srs" +
                                      (code.empty() ? "" : " " + code) + " does");
  };
  if (surely_other_crs(crs, there))
    return refuse("its coordinates are those of " + crs_title(crs) + ", and the points have those of " +
                  crs_title(there));
  constexpr double near = 1000;  // farther from 0 there are no degrees, and no local coordinates measured from a corner
  const bool degrees = bounds.lo.x >= -180 && bounds.hi.x <= 180 && bounds.lo.y >= -90 && bounds.hi.y <= 90;
  if (!degrees || (points.lo.x <= near && points.hi.x >= -near && points.lo.y <= near && points.hi.y >= -near))
    return success();
  const auto side = [](const char* axis, double a, double b) {
    std::array<char, 80> text{};
    std::snprintf(text.data(), text.size(), "%s from %.10g to %.10g", axis, a, b);
    return std::string(text.data());
  };
  return refuse("its coordinates look like degrees, and the points lie at " + side("x", points.lo.x, points.hi.x) +
                ", " + side("y", points.lo.y, points.hi.y));
}

Result<GeoJsonShapes> read_geojson(const std::filesystem::path& path, GeoJson kind) {
  BOOST_OUTCOME_TRY(text, read_whole(path));
  return of_geojson(as_text(text), path.string(), kind);
}

Result<GeoJsonShapes> of_geojson(std::string_view text, const std::string& name, GeoJson kind) {
  const json document = parse_json(text);
  const auto bad = [&](const std::string& reason) { return error(Errc::bad_input, name + ": " + reason); };
  if (document.is_discarded()) return bad("is not JSON");
  Collection collection(kind);
  if (auto added = collection.add(document, ""); !added) return bad(added.error().where);
  GeoJsonShapes found{.lists = collection.take(),
                      .place = {.name = name, .crs = named_crs(document)},
                      .firsts = collection.take_firsts()};
  if (found.lists.empty()) return bad(kind == GeoJson::polygons ? "has no polygon" : "has no line");
  for (const auto& list : found.lists)
    for (const Point& p : list) found.place.bounds.add(p);
  return found;
}

}  // namespace tessera::query
