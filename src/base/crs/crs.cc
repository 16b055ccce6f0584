#include "src/base/crs/crs.h"

#include <charconv>
#include <optional>
#include <string_view>
#include <utility>

#include "src/base/crs/gdal_library.h"
#include "src/base/crs/wkt.h"

namespace tessera {

namespace {

std::string urn(const std::string& code) { return "urn:ogc:def:crs:EPSG::" + code; }

// The code of a system that has a code, or is surely the same as a system with a code; else empty.
std::string surely_code(const GdalLibrary& gdal, OGRSpatialReferenceH reference) {
  if (auto code = epsg_code(gdal, reference); !code.empty()) return code;
  // PROJ's confidence: 100 for an equal definition, 90 when only names differ in spelling.
  constexpr int sure = 90;
  int count = 0;
  int* confidences = nullptr;
  OGRSpatialReferenceH* matches = gdal.OSRFindMatches(reference, nullptr, &count, &confidences);
  std::string code;
  for (int i = 0; i < count && code.empty(); ++i)
    if (confidences[i] >= sure) code = epsg_code(gdal, matches[i]);
  gdal.OSRFreeSRSArray(matches);
  gdal.VSIFree(confidences);
  return code;
}

// The text between the first quotation marks, which is the system's name in any WKT.
std::string name_in(const std::string& wkt) {
  const auto first = wkt.find('"');
  const auto second = first == std::string::npos ? first : wkt.find('"', first + 1);
  return second == std::string::npos ? wkt : wkt.substr(first + 1, second - first - 1);
}

std::string with_code(const std::string& name, const char* code) {
  return code == nullptr || *code == '\0' ? name : name + " (EPSG:" + code + ")";
}

// A system that GDAL understands.
struct Understood {
  const GdalLibrary* gdal;
  SpatialReference reference;
};

std::optional<Understood> understand(const std::string& crs) {
  if (!looks_like_crs(crs)) return std::nullopt;
  const auto gdal = gdal_library();
  if (!gdal) return std::nullopt;
  auto reference = SpatialReference::parse(*gdal.value(), crs);
  if (!reference) return std::nullopt;
  return Understood{gdal.value(), std::move(reference).value()};
}

}  // namespace

std::optional<int> code_in(const std::string& text) {
  constexpr std::string_view epsg = "EPSG:";
  if (!text.starts_with(epsg)) return std::nullopt;
  int code = 0;
  const char *begin = text.data() + epsg.size(), *end = text.data() + text.size();
  const auto [at, problem] = std::from_chars(begin, end, code);
  return problem == std::errc() && at == end && *begin != '-' ? std::optional(code) : std::nullopt;
}

Status check_crs_text(const std::string& text) {
  if (code_in(text)) return success();
  if (const auto wkt = check_wkt(text); !wkt)
    return error(Errc::bad_input, "is neither EPSG:n nor WKT (" + wkt.error().where + ")");
  return success();
}

bool looks_like_crs(const std::string& text) { return check_crs_text(text).has_value(); }

std::string crs_or_none(const std::string& crs) { return looks_like_crs(crs) ? crs : ""; }

Result<std::string> crs_name_or_wkt(const std::string& crs) {
  if (crs.empty()) return undefined_crs;
  BOOST_OUTCOME_TRY(gdal, gdal_library());
  BOOST_OUTCOME_TRY(reference, SpatialReference::parse(*gdal, crs));
  const GdalQuiet quiet(*gdal);
  if (gdal->OSRIsCompound(reference.get()) != 0) gdal->OSRStripVertical(reference.get());
  if (const auto code = surely_code(*gdal, reference.get()); !code.empty()) return urn(code);
  char* text = nullptr;
  const bool written = gdal->OSRExportToWkt(reference.get(), &text) == OGRERR_NONE;
  const std::string name = written ? text : "";
  gdal->VSIFree(text);
  if (!written) return error(Errc::bad_input, "the coordinate system cannot be written as WKT");
  return name;
}

std::string crs_note(const std::string& crs) {
  const auto checked = check_crs_text(crs);
  if (checked) return {};
  return (crs.empty() ? "the result has no coordinate system"
                      : "the result's coordinate system " + checked.error().where) +
         ", and the file says that there is none: programs cannot place it on a map";
}

std::string crs_title(const std::string& crs) {
  const auto understood = understand(crs);
  if (!understood) return name_in(crs);
  const auto& [gdal, reference] = *understood;
  const GdalQuiet quiet(*gdal);
  // A code implies the unit, but a name does not. Metres are not mentioned, because people expect them.
  const auto unit = [&, gdal = gdal, handle = reference.get()](const char* path) -> std::string {
    const char* name = gdal->OSRGetAttrValue(handle, path, 0);
    return name == nullptr || std::string_view(name) == "metre" || std::string_view(name) == "Meter"
               ? ""
               : std::string(" in ") + name;
  };
  const char* vertical = gdal->OSRGetAttrValue(reference.get(), "VERT_CS", 0);
  const char* code = gdal->OSRGetAuthorityCode(reference.get(), "VERT_CS");
  const std::string heights = vertical == nullptr ? ""
                              : code != nullptr   ? " + heights " + with_code(vertical, code)
                                                  : std::string(" + heights ") + vertical + unit("VERT_CS|UNIT");
  if (gdal->OSRIsCompound(reference.get()) != 0) gdal->OSRStripVertical(reference.get());
  const char* given = gdal->OSRGetName(reference.get());
  std::string name = given == nullptr || *given == '\0' ? "unnamed" : given;
  if (gdal->OSRIsGeocentric(reference.get()) != 0) {
    const char* datum = gdal->OSRGetAttrValue(reference.get(), "DATUM", 0);
    name += std::string(", geocentric") + (datum != nullptr ? ", datum " + std::string(datum) : "");
  }
  const std::string horizontal = surely_code(*gdal, reference.get());
  return (horizontal.empty() ? name + unit("PROJCS|UNIT") : with_code(name, horizontal.c_str())) + heights;
}

bool has_heights(const std::string& crs) {
  const auto understood = understand(crs);
  return understood && understood->gdal->OSRIsCompound(understood->reference.get()) != 0;
}

bool same_crs(const std::string& a, const std::string& b) {
  if (a == b) return true;
  const auto first = understand(a), second = understand(b);
  if (!first || !second) return false;
  const GdalLibrary& gdal = *first->gdal;
  const GdalQuiet quiet(gdal);
  OGRSpatialReferenceH one = first->reference.get(), other = second->reference.get();
  const bool compound = gdal.OSRIsCompound(one) != 0;
  if (compound == (gdal.OSRIsCompound(other) != 0)) {
    if (equivalent(gdal, one, other)) return true;
    if (compound) return false;
  }
  if (gdal.OSRIsCompound(one) != 0) gdal.OSRStripVertical(one);
  if (gdal.OSRIsCompound(other) != 0) gdal.OSRStripVertical(other);
  if (equivalent(gdal, one, other)) return true;
  const auto code = surely_code(gdal, one);
  return !code.empty() && code == surely_code(gdal, other);
}

bool surely_other_crs(const std::string& a, const std::string& b) {
  return a != b && understand(a) && understand(b) && !same_crs(a, b);
}

std::string crs_of_name(const std::string& name) {
  if (name.find("CRS84") != std::string::npos && name.find("OGC") != std::string::npos) return "EPSG:4326";
  if (name.find("EPSG") == std::string::npos || looks_like_crs(name)) return name;
  const std::string code = "EPSG:" + name.substr(name.find_last_of(":/") + 1);
  return code_in(code) ? code : name;
}

std::string crs_code(const std::string& crs) {
  const auto name = crs.empty() ? error(Errc::bad_input, "") : crs_name_or_wkt(crs);
  const std::string code = crs_of_name(name ? name.value() : crs);
  return code_in(code) ? code : "";
}

Status check_crs(const std::string& crs) {
  if (const auto checked = check_crs_text(crs); !checked)
    return error(Errc::bad_input, "the coordinate system " + checked.error().where);
  const auto gdal = gdal_library();
  if (!gdal) return success();
  BOOST_OUTCOME_TRY(reference, SpatialReference::parse(*gdal.value(), crs));
  static_cast<void>(reference);
  return success();
}

}  // namespace tessera
