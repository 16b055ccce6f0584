// The periods of a cloud, as its user gives them.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/input/cloud/cloud.h"

namespace tessera {

// Sets options.periodic to the sides of the box that the files state, if the options ask for that. Error usage for a
// file that states none, or another one than the first.
Status take_box_of_files(std::span<const FileInfo> files, CloudOptions& options);

// Sets options.period from options.periodic. A period that would round shifts is rounded, with a warning, or refused if
// options.snap is false. Error usage. REQUIRES: the dimension is settled.
Status settle_period(CloudOptions& options, std::vector<std::string>& warnings);

// What was done to the coordinates of a periodic cloud, in sentences.
std::vector<std::string> sentences_of_period(const CloudCounts& counts, const Period& period);

// Refuses a period so large that rounding blurs the cloud. Returns the end of a sentence, or "".
std::string why_too_large(const CloudCounts& counts, const Period& period);

}  // namespace tessera
