// The coordinate system of a cloud of many files.
#pragma once

#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/input/reader.h"

namespace tessera {

struct CloudCrs {
  std::string crs;                    // WKT, "EPSG:n", or empty
  std::vector<std::string> warnings;  // sentences for people
};

// Returns `given` if it is not empty, else the system of the files; some files may have none. Error bad_input when two
// files have different systems, because the points of one of them would be in the wrong place.
Result<CloudCrs> settle_crs(const std::vector<FileInfo>& files, const std::string& given);

}  // namespace tessera
