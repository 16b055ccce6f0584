// Reads a coordinate system as a user gives it.
#pragma once

#include <string>

#include "src/base/result.h"

namespace tessera {

// `text`: "EPSG:n", WKT, or the name of a file that holds one of them (a .prj). Errors: usage for a text that is none
// of these or that GDAL does not understand; io for a file that cannot be read.
Result<std::string> parse_crs(const std::string& text);

}  // namespace tessera
