// The coordinate system that GeoTIFF keys describe.
// Source: OGC GeoTIFF Standard 1.1 (19-008r4); LAS 1.4 - R15 stores its three tags in three records.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "src/base/result.h"

namespace tessera {

// The tags GeoKeyDirectory (34735), GeoDoubleParams (34736) and GeoAsciiParams (34737), as bytes, little endian.
struct GeoTiffKeys {
  std::span<const std::byte> directory, doubles, ascii;
};

// "EPSG:n" when the keys mean exactly what this code means, else WKT: with the units, the parameters and the vertical
// system that the keys give. Errors: no GDAL (io); keys of which GDAL makes no system (bad_input).
Result<std::string> crs_of(const GeoTiffKeys& given);

}  // namespace tessera
