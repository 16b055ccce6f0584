// Coordinate systems, as inputs and manifests have them: WKT, "EPSG:n", or nothing. What they mean is asked of GDAL.
#pragma once

#include <optional>
#include <string>

#include "src/base/result.h"

namespace tessera {

// What GDAL and QGIS take for "nobody knows": without it GeoJSON would count as longitude and latitude.
inline constexpr const char* undefined_crs = "LOCAL_CS[\"Undefined Cartesian SRS\"]";

// The n of "EPSG:n".
std::optional<int> code_in(const std::string& text);

// Whether a text is "EPSG:n", or WKT that names no file (wkt.h). Strangers may say anything, and GDAL and PROJ open the
// files and addresses that other texts name: here, and in programs that open our files. Error bad_input: why not, as
// the end of a sentence.
Status check_crs_text(const std::string& text);
bool looks_like_crs(const std::string& text);
// `crs` if it is one of these, else empty: what may go into files.
std::string crs_or_none(const std::string& crs);

// "urn:ogc:def:crs:EPSG::n" when the horizontal system, or one that is surely the same, has a code; else WKT. Errors:
// no GDAL (io), a text that it does not understand (bad_input).
Result<std::string> crs_name_or_wkt(const std::string& crs);

// A sentence when there is none, or none that looks like one; else empty.
std::string crs_note(const std::string& crs);

// For people: "RGF93 v1 / Lambert-93 (EPSG:2154) + heights NGF-IGN69 height (EPSG:5720)", the name alone where no code
// is surely the same, "unnamed, geocentric" where there is no name. What GDAL does not understand (or all of it,
// without GDAL) is named as it names itself.
std::string crs_title(const std::string& crs);

// Whether points of both may stand in one cloud: the same horizontal (or geocentric) system, and the same vertical one
// if both have one. Texts are compared when one of them is not understood, or there is no GDAL.
bool same_crs(const std::string& a, const std::string& b);

// Whether both are understood, and are not the same (same_crs()): then points of the one have no place in the other.
bool surely_other_crs(const std::string& a, const std::string& b);

// "EPSG:n" of what GeoJSON and OGC call systems: URNs, addresses, "EPSG:n". CRS84 counts as EPSG:4326, as coordinates
// are x, y whatever order an authority gives the axes. Other texts as they are.
std::string crs_of_name(const std::string& name);

// "EPSG:n" when the horizontal system, or one that is surely the same, has a code; else empty.
std::string crs_code(const std::string& crs);

// Whether it says what the heights mean.
bool has_heights(const std::string& crs);

// Error bad_input when it is none (check_crs_text), or GDAL does not understand it; success when it does, or when there
// is no GDAL to ask.
Status check_crs(const std::string& crs);

}  // namespace tessera
