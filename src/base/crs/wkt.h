// Checks foreign well-known text before a library reads it.
#pragma once

#include <string_view>

#include "src/base/result.h"

namespace tessera {

// Checks that a text is WKT (1 or 2) of a coordinate system and names no file outside PROJ's own folders. PROJ opens
// files that are named by an EXTENSION, PARAMETERFILE, GEOIDMODEL, METHOD, or a REMARK with a PROJ string; GDAL opens
// those that an AUTHORITY names. So these texts must not contain a slash. A name without a slash is looked for only in
// PROJ's folders (proj_files.h). Names, remarks and addresses may contain slashes, but then no PROJ string. Error
// bad_input: a sentence about "it".
// Source: OGC 18-010r11 (WKT 2), OGC 01-009 (WKT 1). Which texts name files: PROJ 9.1.1 and GDAL 3.6.2.
Status check_wkt(std::string_view text);

}  // namespace tessera
