// The system of a result's coordinates, as clients of maps name it (OGC API - Features, part 2).
#pragma once

#include <string>

#include "src/base/result.h"

namespace tessera {

struct StorageCrs {
  std::string uri;       // http://www.opengis.net/def/crs/EPSG/0/2154; empty when the horizontal system has no code
  bool swapped = false;  // there y comes before x, as EPSG defines it: latitude before longitude, or north before east
};

// Errors as those of crs_name_or_wkt().
Result<StorageCrs> storage_crs(const std::string& crs);

}  // namespace tessera
