#include "src/base/crs/survey_system.h"

#include <cmath>
#include <optional>

#include "src/base/crs/crs.h"
#include "src/base/crs/gdal_library.h"

namespace tessera {

namespace {

std::optional<LengthUnit> length_unit(double metres) {
  // The two feet differ by two millionths.
  const auto is = [&](double of) { return std::abs(metres - of) < 1e-9 * of; };
  if (is(1)) return LengthUnit::metre;
  if (is(0.3048)) return LengthUnit::foot;
  if (is(1200.0 / 3937)) return LengthUnit::us_survey_foot;
  return std::nullopt;
}

}  // namespace

CoordinateUnits coordinate_units(const std::string& crs) {
  CoordinateUnits units;
  const auto gdal = gdal_library();
  if (crs.empty() || !gdal) return units;
  const auto reference = SpatialReference::parse(*gdal.value(), crs);
  if (!reference) return units;
  const GdalQuiet quiet(*gdal.value());
  char* name = nullptr;
  const auto told = [&](double metres) -> std::string {
    const auto known = length_unit(metres);
    if (!known) return name == nullptr ? "" : name;
    return *known == LengthUnit::metre ? "metre" : *known == LengthUnit::foot ? "foot" : "US survey foot";
  };
  const auto& library = *gdal.value();
  OGRSpatialReferenceH system = reference.value().get();
  if (library.OSRIsGeographic(system) != 0) {
    units.horizontal = "degree";
  } else {
    units.horizontal = told(library.OSRGetLinearUnits(system, &name));
    units.vertical = units.horizontal;
  }
  if (library.OSRGetAttrValue(system, "VERT_CS", 0) != nullptr)
    units.vertical = told(library.OSRGetTargetLinearUnits(system, "VERT_CS", &name));
  return units;
}

Result<SurveySystem> survey_system(const std::string& crs) {
  SurveySystem system;
  if (crs.empty()) return system;
  BOOST_OUTCOME_TRY(gdal, gdal_library());
  BOOST_OUTCOME_TRY(reference, SpatialReference::parse(*gdal, crs));
  const GdalQuiet quiet(*gdal);
  system.title = crs_title(crs);
  BOOST_OUTCOME_TRY(name, crs_name_or_wkt(crs));
  if (constexpr std::string_view urn = "urn:ogc:def:crs:EPSG::"; name.starts_with(urn))
    system.epsg = name.substr(urn.size());
  char* text = nullptr;
  if (gdal->OSRExportToWkt(reference.get(), &text) == OGRERR_NONE) system.wkt = text;
  gdal->VSIFree(text);

  const auto refuse = [&](const std::string& what) {
    return error(Errc::usage,
                 "the coordinate system " + system.title + " has " + what +
                     ", but surveyors' formats have only metres, feet and US survey feet: reproject the points");
  };
  if (gdal->OSRIsGeographic(reference.get()) != 0) return refuse("degrees");
  char* unit = nullptr;
  const auto horizontal = length_unit(gdal->OSRGetLinearUnits(reference.get(), &unit));
  if (!horizontal) return refuse(std::string("the unit ") + (unit != nullptr ? unit : "unknown"));
  system.horizontal = system.vertical = *horizontal;
  if (gdal->OSRGetAttrValue(reference.get(), "VERT_CS", 0) == nullptr) return system;
  const auto vertical = length_unit(gdal->OSRGetTargetLinearUnits(reference.get(), "VERT_CS", &unit));
  if (!vertical) return refuse(std::string("heights in the unit ") + (unit != nullptr ? unit : "unknown"));
  system.vertical = *vertical;
  return system;
}

}  // namespace tessera
