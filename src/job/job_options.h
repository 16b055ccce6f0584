// What a job is asked to do, whoever asks: the command or a program that uses the library.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/result.h"
#include "src/delaunay/run/run_options.h"
#include "src/input/cloud/cloud.h"
#include "src/tiling/partition.h"

namespace tessera {

struct JobOptions : RunOptions {
  CloudOptions cloud;  // dimension 0: 2 when no input holds z, else 3; settled by open_cloud()
  PartitionKind partition = PartitionKind::kdtree;
  std::uint64_t max_points_per_tile = 0;  // 0: chosen from memory and threads, unless `tiles` is given
  std::uint32_t tiles = 0;
  std::vector<std::string> command = {};             // for the manifest: how the job was started
  std::function<void(const std::string&)> log = {};  // what happens, for people
};

// Equal keys = the same result: everything above that it depends on, as text.
std::string options_key(const JobOptions& options);

// Four numbers, xmin, ymin, xmax, ymax, mean any z; six, in 3D, xmin, ymin, zmin, xmax, ymax, zmax. Error usage, with
// the end of a sentence: another number of them, NaN, an empty box.
Result<Box> crop_box(std::span<const double> numbers, int dimension);

// "all", "first", "last", "single". Error usage, with the end of a sentence, here and below.
Result<Returns> parse_returns(std::string_view text);
// "first", "last", "lowest", "highest".
Result<DuplicatePolicy> parse_kept_point(std::string_view text);
// "auto", "cells", "points".
Result<StoreAs> parse_store_as(std::string_view text);
// Whether these are flags that LAS has.
Status check_flags(const std::vector<std::string>& names);

constexpr std::uint32_t threads_max = 1024;

}  // namespace tessera
