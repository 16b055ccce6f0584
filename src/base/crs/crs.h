// Coordinate systems as texts, as inputs and manifests have them: WKT, "EPSG:n", or empty. GDAL says what they mean.
#pragma once

#include <optional>
#include <string>

#include "src/base/result.h"

namespace tessera {

// The text that GDAL and QGIS take for an unknown system. Without it GeoJSON would count as longitude and latitude.
inline constexpr const char* undefined_crs = "LOCAL_CS[\"Undefined Cartesian SRS\"]";

// Returns the n of "EPSG:n". Nothing for other texts.
std::optional<int> code_in(const std::string& text);

// Whether a text is "EPSG:n", or WKT that names no file (wkt.h). A foreign text may contain anything. GDAL and PROJ
// open the files and addresses that a text names, in this program and in programs that open its files. Error bad_input:
// the reason, as the end of a sentence.
Status check_crs_text(const std::string& text);
bool looks_like_crs(const std::string& text);
// Returns `crs` if check_crs_text() accepts it, else an empty text. Only such texts may go into files.
std::string crs_or_none(const std::string& crs);

// Returns "urn:ogc:def:crs:EPSG::n" when the horizontal system, or one that is surely the same, has a code; else WKT.
// Errors: io without GDAL; bad_input for a text that GDAL does not understand.
Result<std::string> crs_name_or_wkt(const std::string& crs);

// Returns a sentence for people when check_crs_text() refuses the text or the text is empty. Else returns an empty
// text.
std::string crs_note(const std::string& crs);

// A title for people: "RGF93 v1 / Lambert-93 (EPSG:2154) + heights NGF-IGN69 height (EPSG:5720)". The title has no code
// where no code is surely the same, and "unnamed" where there is no name: "unnamed, geocentric". A text that GDAL does
// not understand is called by the name in the text. So is every text without GDAL.
std::string crs_title(const std::string& crs);

// Whether points of both systems may be in one cloud: the horizontal (or geocentric) systems are the same, and the
// vertical systems are the same if both have one. The texts are compared when GDAL does not understand one of them or
// is missing.
bool same_crs(const std::string& a, const std::string& b);

// Whether GDAL understands both systems and they are not the same (same_crs()). Then coordinates of one system have no
// meaning in the other.
bool surely_other_crs(const std::string& a, const std::string& b);

// Turns the names that GeoJSON and OGC give to systems (URNs, addresses, "EPSG:n") into "EPSG:n". CRS84 becomes
// EPSG:4326, because coordinates are x, y here whatever the order of axes of an authority. Other texts stay as they
// are.
std::string crs_of_name(const std::string& name);

// Returns "EPSG:n" when the horizontal system, or one that is surely the same, has a code; else an empty text.
std::string crs_code(const std::string& crs);

// Whether the system says what heights mean.
bool has_heights(const std::string& crs);

// Checks a text as far as possible. Error bad_input when check_crs_text() refuses it, or when GDAL does not understand
// it. Success also when GDAL is missing.
Status check_crs(const std::string& crs);

}  // namespace tessera
