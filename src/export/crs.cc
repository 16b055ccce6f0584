#include "src/export/crs.h"

#include <string_view>

#include "src/export/gdal_library.h"

namespace tessera::exports {

namespace {

// "urn:..." of a system that carries its code; empty when it has none.
std::string urn(const GdalLibrary& gdal, OGRSpatialReferenceH reference) {
  const char* authority = gdal.OSRGetAuthorityName(reference, nullptr);
  const char* code = gdal.OSRGetAuthorityCode(reference, nullptr);
  if (authority == nullptr || code == nullptr || std::string(authority) != "EPSG") return {};
  return "urn:ogc:def:crs:EPSG::" + std::string(code);
}

}  // namespace

bool looks_like_crs(const std::string& text) {
  const auto all = [](std::string_view part, const char* characters) {
    return !part.empty() && part.find_first_not_of(characters) == std::string_view::npos;
  };
  constexpr std::string_view epsg = "EPSG:";
  if (text.starts_with(epsg)) return all(std::string_view(text).substr(epsg.size()), "0123456789");
  const auto keyword = std::string_view(text).substr(0, text.find_first_of("[("));
  return keyword.size() < text.size() && all(keyword, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_ \t\r\n");
}

Result<std::string> crs_name_or_wkt(const std::string& crs) {
  if (crs.empty()) return undefined_crs;
  BOOST_OUTCOME_TRY(gdal, gdal_library());
  BOOST_OUTCOME_TRY(reference, SpatialReference::parse(*gdal, crs));
  const GdalQuiet quiet(*gdal);
  if (gdal->OSRIsCompound(reference.get()) != 0) gdal->OSRStripVertical(reference.get());
  if (auto name = urn(*gdal, reference.get()); !name.empty()) return name;
  // PROJ's confidence: 100 for an equal definition, 90 when only names differ in spelling.
  constexpr int sure = 90;
  int count = 0;
  int* confidences = nullptr;
  OGRSpatialReferenceH* matches = gdal->OSRFindMatches(reference.get(), nullptr, &count, &confidences);
  std::string name;
  for (int i = 0; i < count && name.empty(); ++i)
    if (confidences[i] >= sure) name = urn(*gdal, matches[i]);
  gdal->OSRFreeSRSArray(matches);
  gdal->VSIFree(confidences);
  if (!name.empty()) return name;
  char* text = nullptr;
  const bool written = gdal->OSRExportToWkt(reference.get(), &text) == OGRERR_NONE;
  name = written ? text : "";
  gdal->VSIFree(text);
  if (!written) return error(Errc::bad_input, "the coordinate system of the result cannot be written as WKT");
  return name;
}

std::string crs_note(const std::string& crs) {
  if (looks_like_crs(crs)) return {};
  return std::string(crs.empty() ? "the result has no coordinate system"
                                 : "the result's coordinate system is neither WKT nor EPSG:n") +
         ", and the file says that there is none: programs cannot place it on a map";
}

}  // namespace tessera::exports
