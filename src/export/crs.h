// Coordinate systems, as the manifest has them: WKT, "EPSG:n", or nothing.
#pragma once

#include <string>

#include "src/base/result.h"

namespace tessera::exports {

// What GDAL and QGIS take for "nobody knows": without it GeoJSON would count as longitude and latitude.
inline constexpr const char* undefined_crs = "LOCAL_CS[\"Undefined Cartesian SRS\"]";

// Whether a text is "EPSG:n", or WKT by its looks. Input files may say anything, and other texts GDAL takes for names
// of files or addresses on the net, which it opens: here, and in programs that open our files.
bool looks_like_crs(const std::string& text);

// "urn:ogc:def:crs:EPSG::n" when the horizontal system, or one that is surely the same, has a code; else WKT. Errors:
// no GDAL (io), a text that it does not understand (bad_input).
Result<std::string> crs_name_or_wkt(const std::string& crs);

// A sentence when there is none, or none that looks like one; else empty.
std::string crs_note(const std::string& crs);

}  // namespace tessera::exports
