// The periods of a cloud, as its user gives them.
#pragma once

#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/input/cloud/cloud.h"

namespace tessera {

// Sets options.period from options.periodic. A period that would round shifts is rounded, with a warning, or refused if
// options.snap is false. Error usage. REQUIRES: the dimension is settled.
Status settle_period(CloudOptions& options, std::vector<std::string>& warnings);

// What was done to the coordinates of a periodic cloud, in sentences.
std::vector<std::string> sentences_of_period(const CloudCounts& counts, const Period& period);

// Refuses a period so large that rounding blurs the cloud. Returns the end of a sentence, or "".
std::string why_too_large(const CloudCounts& counts, const Period& period);

}  // namespace tessera
