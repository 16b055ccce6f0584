#include "src/input/ept/ept_info.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "src/base/crs/crs.h"
#include "src/base/json/json_text.h"
#include "src/base/printable.h"
#include "src/input/bytes/number_type.h"

namespace tessera::ept {
namespace {

using nlohmann::json;

constexpr std::uint64_t text_bytes_max = std::uint64_t{16} << 20;
constexpr std::size_t dimensions_max = 1024;

// Reads the members of the object, and says what is wrong with them. Errors have no name of a file.
class InfoReader {
 public:
  InfoReader(const json& all, Info& info) : all_(all), info_(info) {}

  Status read() {
    BOOST_OUTCOME_TRYV(read_version());
    BOOST_OUTCOME_TRYV(read_tiles());
    BOOST_OUTCOME_TRYV(read_box("bounds", info_.cube));
    if (all_.contains("boundsConforming")) {
      BOOST_OUTCOME_TRYV(read_box("boundsConforming", info_.conforming));
    }
    BOOST_OUTCOME_TRYV(read_numbers());
    BOOST_OUTCOME_TRYV(read_schema());
    read_crs();
    return success();
  }

 private:
  static Error bad(const std::string& what) { return error(Errc::bad_input, what); }

  std::string text(const json& object, const char* name) const {
    const auto at = object.find(name);
    return at != object.end() && at->is_string() ? at->get<std::string>() : std::string();
  }

  Status read_version() const {
    const std::string version = text(all_, "version");
    if (version.starts_with("1.")) return success();
    return bad("\"version\" is " + (version.empty() ? "missing" : in_quotes(version)) + ", and only 1.x can be read");
  }

  Status read_tiles() {
    const std::string tiles = text(all_, "dataType"), hierarchy = text(all_, "hierarchyType");
    if (tiles == "laszip")
      info_.tiles = Info::Tiles::laz;
    else if (tiles == "binary")
      info_.tiles = Info::Tiles::binary;
    else if (tiles == "zstandard")
      info_.tiles = Info::Tiles::zstd;
    else
      return bad("\"dataType\" is " + in_quotes(tiles) + ", which is none of laszip, binary and zstandard");
    if (hierarchy != "json") return bad("\"hierarchyType\" is " + in_quotes(hierarchy) + ", and only json can be read");
    return success();
  }

  Status read_box(const char* name, Bounds& box) const {
    const auto at = all_.find(name);
    const auto wrong = [&] {
      return bad(std::string("\"") + name + "\" is not a box of six numbers, [xmin, ymin, zmin, xmax, ymax, zmax]");
    };
    if (at == all_.end() || !at->is_array() || at->size() != 6) return wrong();
    for (int i = 0; i < 6; ++i) {
      const json& number = (*at)[static_cast<std::size_t>(i)];
      if (!number.is_number() || !std::isfinite(number.get<double>())) return wrong();
      (i < 3 ? box.lo : box.hi)[i % 3] = number.get<double>();
    }
    for (int axis = 0; axis < 3; ++axis)
      if (!(box.lo[axis] <= box.hi[axis])) return wrong();
    return success();
  }

  Status read_numbers() {
    const auto points = all_.find("points"), span = all_.find("span");
    if (points == all_.end() || !points->is_number_unsigned()) return bad("\"points\" is not the number of points");
    info_.points = points->get<std::uint64_t>();
    if (info_.points > (std::uint64_t{1} << 48)) return bad("\"points\" is impossibly large");
    if (span == all_.end() || !span->is_number() || !(span->get<double>() >= 1))
      return bad("\"span\" is not a number of voxels");
    info_.span = span->get<double>();
    if (!(info_.cube.hi.x > info_.cube.lo.x) || !std::isfinite(info_.cube.hi.x - info_.cube.lo.x))
      return bad("\"bounds\" is no cube: it has no width");
    return success();
  }

  Status read_schema() {
    const auto schema = all_.find("schema");
    if (schema == all_.end() || !schema->is_array() || schema->empty() || schema->size() > dimensions_max)
      return bad("\"schema\" is not a list of 1 to " + std::to_string(dimensions_max) + " dimensions");
    std::set<std::string> names;
    for (const auto& entry : *schema) {
      BOOST_OUTCOME_TRY(dimension, read_dimension(entry));
      if (!names.insert(dimension.name).second) return bad("\"schema\" has " + in_quotes(dimension.name) + " twice");
      dimension.at = info_.record_bytes;
      info_.record_bytes += size_of(dimension.type);
      info_.dimensions.push_back(std::move(dimension));
    }
    for (const char* axis : {"X", "Y", "Z"}) {
      const Dimension* found = find(info_, axis);
      if (found == nullptr) return bad(std::string("\"schema\" has no ") + axis);
      if (size_of(found->type) == 8 && found->type != AttributeType::f64)
        return bad(std::string("\"schema\": ") + axis + " has integers of 64 bits, which doubles would round");
    }
    return success();
  }

  Result<Dimension> read_dimension(const json& entry) const {
    Dimension dimension;
    dimension.name = entry.is_object() ? text(entry, "name") : "";
    if (dimension.name.empty()) return bad("\"schema\" has a dimension without a name");
    const auto wrong = [&](const std::string& what) {
      return bad("\"schema\": " + in_quotes(dimension.name) + " " + what);
    };
    const std::string kind = text(entry, "type");
    const auto size = entry.find("size");
    const std::uint64_t bytes = size != entry.end() && size->is_number_unsigned() ? size->get<std::uint64_t>() : 0;
    const auto type = type_of(kind, bytes);
    if (!type)
      return wrong("is of type " + in_quotes(kind) + " with " + std::to_string(bytes) + " bytes, which is unknown");
    dimension.type = *type;
    for (const auto& [name, value] : {std::pair("scale", &dimension.scale), {"offset", &dimension.offset}}) {
      const auto at = entry.find(name);
      if (at == entry.end() || at->is_null()) continue;
      if (!at->is_number() || !std::isfinite(at->get<double>())) return wrong(std::string("has no valid ") + name);
      *value = at->get<double>();
    }
    if (dimension.scale == 0) return wrong("has the scale 0");
    return dimension;
  }

  static std::optional<AttributeType> type_of(const std::string& kind, std::uint64_t bytes) {
    if (kind == "float") return number_type(NumberKind::floating, bytes);
    if (kind == "signed") return number_type(NumberKind::with_sign, bytes);
    if (kind == "unsigned") return number_type(NumberKind::without_sign, bytes);
    return {};
  }

  // The text in well-known text is more exact than the code, as in LAS.
  void read_crs() {
    const auto srs = all_.find("srs");
    if (srs == all_.end() || !srs->is_object()) return;
    const std::string wkt = text(*srs, "wkt"), authority = text(*srs, "authority"), code = text(*srs, "horizontal");
    const bool digits = !code.empty() && code.size() < 8 && code.find_first_not_of("0123456789") == std::string::npos;
    if (!wkt.empty() && check_crs_text(wkt).has_value())
      info_.crs = wkt;
    else if (authority == "EPSG" && digits)
      info_.crs = "EPSG:" + code;
    else if (!wkt.empty())
      info_.crs_note = "its coordinate system is not understood: " + in_quotes(wkt);
  }

  const json& all_;
  Info& info_;
};

}  // namespace

double Info::slack() const {
  double slack = 1e-9 * (cube.hi.x - cube.lo.x);
  for (const char* axis : {"X", "Y", "Z"}) slack = std::max(slack, std::abs(find(*this, axis)->scale));
  for (int axis = 0; axis < 3; ++axis) slack = std::max(slack, 1e-15 * std::abs(cube.hi[axis] + cube.lo[axis]));
  return slack;
}

const Dimension* find(const Info& info, std::string_view name) {
  for (const auto& dimension : info.dimensions)
    if (dimension.name == name) return &dimension;
  return nullptr;
}

Result<std::string> read_text(const ByteSource& source) {
  if (source.size() > text_bytes_max)
    return error(Errc::bad_input, source.path().string() + ": has " + std::to_string(source.size()) +
                                      " bytes, and a file of an EPT hierarchy has at most " +
                                      std::to_string(text_bytes_max));
  std::string text(source.size(), '\0');
  BOOST_OUTCOME_TRYV(source.read(0, std::as_writable_bytes(std::span(text))));
  return text;
}

Result<Info> read_info(const ByteSource& source) {
  BOOST_OUTCOME_TRY(text, read_text(source));
  const json all = parse_json(text);
  const std::string path = source.path().string();
  if (!all.is_object()) return error(Errc::bad_input, path + ": is not a JSON object, as an ept.json is");
  Info info;
  info.path = source.path();
  if (const auto status = InfoReader(all, info).read(); status.has_error())
    return Error{status.error().code, path + ": " + status.error().where};
  return info;
}

}  // namespace tessera::ept
