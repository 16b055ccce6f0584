// The one coordinate system of a cloud of many files.
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

// `given` when it is not empty; else that of the files, of which some may have none. Error bad_input when two files
// have different systems: where each point stands would be wrong for one of them.
Result<CloudCrs> settle_crs(const std::vector<FileInfo>& files, const std::string& given);

}  // namespace tessera
