// Reads the coordinate system from GeoTIFF keys.
// Source: OGC GeoTIFF Standard 1.1 (19-008r4). LAS 1.4 - R15 stores the three tags in three records.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "src/base/result.h"

namespace tessera {

// The bytes of the tags GeoKeyDirectory (34735), GeoDoubleParams (34736) and GeoAsciiParams (34737), little endian.
struct GeoTiffKeys {
  std::span<const std::byte> directory, doubles, ascii;
};

// Returns "EPSG:n" when the keys mean exactly what this code means, else WKT with the units, the parameters and the
// vertical system of the keys. Errors: io without GDAL; bad_input for keys from which GDAL makes no system.
Result<std::string> crs_of(const GeoTiffKeys& given);

}  // namespace tessera
