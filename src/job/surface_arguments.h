// What options of surfaces say as text.
#pragma once

#include <string>

#include "src/base/result.h"
#include "src/surface/surface.h"

namespace tessera {

// Each with error usage, which says what there is.

// auto, vertical, fields, scan-angle, point:X,Y,Z;X,Y,Z;..., and, if files may be read, track:FILE.
Result<SensorOptions> parse_sensors(const std::string& text, bool files);
// closed, open, free.
Result<SurfaceOptions::Bottom> parse_bottom(const std::string& text);
// Whether "solid", else "empty".
Result<bool> parse_unknown(const std::string& text);
// A number above 0, or full: infinity.
Result<double> parse_ray_length(const std::string& text);
// A length above 0, or auto: 0.
Result<double> parse_sigma(const std::string& text);

}  // namespace tessera
