// The system of a result's coordinates, as map clients name it (OGC API - Features, part 2).
#pragma once

#include <string>

#include "src/base/result.h"

namespace tessera {

struct StorageCrs {
  std::string uri;  // http://www.opengis.net/def/crs/EPSG/0/2154; empty when the horizontal system has no code
  // y comes before x, as EPSG defines the system: latitude before longitude, or north before east
  bool swapped = false;
};

// Returns the errors of crs_name_or_wkt().
Result<StorageCrs> storage_crs(const std::string& crs);

}  // namespace tessera
