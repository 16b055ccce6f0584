// Parses the options of surfaces.
#pragma once

#include <string>

#include "src/base/result.h"
#include "src/surface/surface.h"

namespace tessera {

// All functions return error usage, with the values that are allowed.

// Parses auto, vertical, fields, scan-angle, point:X,Y,Z;X,Y,Z;..., and, if files may be read, track:FILE.
Result<SensorOptions> parse_sensors(const std::string& text, bool files);
// Parses closed, open, free.
Result<SurfaceOptions::Bottom> parse_bottom(const std::string& text);
// Returns true for "solid", false for "empty".
Result<bool> parse_unknown(const std::string& text);
// Parses a number above 0, or full, which is infinity.
Result<double> parse_ray_length(const std::string& text);
// Parses a length above 0, or auto, which is 0.
Result<double> parse_sigma(const std::string& text);

}  // namespace tessera
