// Coordinate systems as surveyors' files describe them, with the units of coordinates.
#pragma once

#include <cstdint>
#include <string>

#include "src/base/result.h"

namespace tessera {

enum class LengthUnit : std::uint8_t { metre, foot, us_survey_foot };

// A system with units of length.
struct SurveySystem {
  LengthUnit horizontal = LengthUnit::metre;
  LengthUnit vertical = LengthUnit::metre;  // the horizontal unit when the system does not say
  std::string title;                        // for people
  std::string epsg;                         // the code of the horizontal system, if one is surely the same; else empty
  std::string wkt;
};

// The units of coordinates, for people: "metre", "foot", "US survey foot", "degree", or the system's own name. Empty
// when there is no system or no GDAL, or when GDAL does not understand the system.
struct CoordinateUnits {
  // when the system does not say, the unit of heights is the horizontal one, but empty for degrees
  std::string horizontal, vertical;
};
CoordinateUnits coordinate_units(const std::string& crs);

// Describes `crs`, which is WKT or "EPSG:n". An empty text means metres without names. Errors: io without GDAL;
// bad_input for a text that GDAL does not understand; usage for degrees and for units other than those above.
Result<SurveySystem> survey_system(const std::string& crs);

}  // namespace tessera
