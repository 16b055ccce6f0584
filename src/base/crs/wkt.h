// Well-known text of strangers, before a library reads it.
#pragma once

#include <string_view>

#include "src/base/result.h"

namespace tessera {

// Whether a text is WKT (1 or 2) of a coordinate system that names no file but those of PROJ's own folders. PROJ opens
// what an EXTENSION, a PARAMETERFILE, a GEOIDMODEL, a METHOD or a REMARK with a PROJ string in it names, GDAL what an
// AUTHORITY does: so no text of these may hold a slash, and what has none is looked for in PROJ's folders alone (see
// proj_files.h). Only names, remarks and addresses may hold slashes, and no PROJ string then. Error bad_input: a
// sentence about "it". Source: OGC 18-010r11 (WKT 2), OGC 01-009 (WKT 1); what names files: PROJ 9.1.1 and GDAL 3.6.2.
Status check_wkt(std::string_view text);

}  // namespace tessera
