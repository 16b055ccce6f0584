// Where the input can be cut, so that several processes read it.
#pragma once

#include <cstdint>
#include <vector>

#include "src/input/cloud/cloud.h"

namespace tessera {

// Cuts the whole input, in order, into splits of about `points` points, where files can be entered. Opens the files
// that are larger. Errors: those of the readers.
Result<std::vector<InputSplit>> cut_into_splits(const Cloud& cloud, std::uint64_t points);

}  // namespace tessera
