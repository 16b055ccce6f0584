// A coordinate system as surveyors' files tell it: with the units of its coordinates.
#pragma once

#include <cstdint>
#include <string>

#include "src/base/result.h"

namespace tessera {

enum class LengthUnit : std::uint8_t { metre, foot, us_survey_foot };

struct SurveySystem {
  LengthUnit horizontal = LengthUnit::metre;
  LengthUnit vertical = LengthUnit::metre;  // like the horizontal one when the system does not say
  std::string title;                        // for people
  std::string epsg;                         // the code of the horizontal system, if one is surely the same; or empty
  std::string wkt;
};

// What coordinates count, for people: "metre", "foot", "US survey foot", "degree", or as the system calls it. Empty
// where nobody knows: there is no system, or no GDAL, or GDAL does not understand it.
struct CoordinateUnits {
  std::string horizontal, vertical;  // heights: like the horizontal one when the system does not say, but for degrees
};
CoordinateUnits coordinate_units(const std::string& crs);

// What `crs`, WKT or "EPSG:n", says; empty: metres, and no names. Errors: no GDAL (io), a text that it does not
// understand (bad_input), degrees and other units than those above (usage).
Result<SurveySystem> survey_system(const std::string& crs);

}  // namespace tessera
