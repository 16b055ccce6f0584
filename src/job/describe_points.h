// What `tessera info --stats` says of a cloud after reading all its points: classes, returns, flags, box, density.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/input/cloud/cloud.h"

namespace tessera {

// Returns the attributes that the cloud must be opened with so that they are counted; those that its files have.
std::vector<std::string> described_attributes(const Cloud& cloud);

// Reads the whole cloud through its filters. Errors: of reading.
Result<nlohmann::ordered_json> describe_points(const Cloud& cloud);

}  // namespace tessera
