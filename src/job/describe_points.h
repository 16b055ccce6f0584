// What `tessera info --stats` tells of a cloud, after reading all its points: classes, returns, flags, box, density.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/input/cloud/cloud.h"

namespace tessera {

// The attributes to open a cloud with, so that they are counted: of those that its files have.
std::vector<std::string> described_attributes(const Cloud& cloud);

// Reads the whole cloud, with its filters. Errors: those of reading.
Result<nlohmann::ordered_json> describe_points(const Cloud& cloud);

}  // namespace tessera
