// What a job is asked to do, by the command or by a program that uses the library.
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
  CloudOptions cloud;  // dimension 0: 2 when no input has z, else 3; open_cloud() sets it
  PartitionKind partition = PartitionKind::kdtree;
  std::uint64_t max_points_per_tile = 0;  // 0: chosen from memory and threads, unless `tiles` is given
  std::uint32_t tiles = 0;
  std::vector<std::string> command = {};             // for the manifest: how the job was started
  std::string place = {};                            // where the result goes in the end; empty: it stays in its folder
  std::function<void(const std::string&)> log = {};  // called with what happens, in sentences for people
};

// Returns all options on which the result depends, as text. Equal keys mean equal results.
std::string options_key(const JobOptions& options);

// Makes a box of numbers. Four numbers, xmin, ymin, xmax, ymax, allow any z; six numbers, in 3D only, are xmin, ymin,
// zmin, xmax, ymax, zmax. Error usage, with the end of a sentence, for another count, NaN, or an empty box.
Result<Box> crop_box(std::span<const double> numbers, int dimension);

// Parses "all", "first", "last", "single". Error usage, with the end of a sentence, here and below.
Result<Returns> parse_returns(std::string_view text);
// Parses "first", "last", "lowest", "highest".
Result<DuplicatePolicy> parse_kept_point(std::string_view text);
// Parses "auto", "cells", "points".
Result<StoreAs> parse_store_as(std::string_view text);
// Checks that these are names of flags of LAS.
Status check_flags(const std::vector<std::string>& names);

constexpr std::uint32_t threads_max = 1024;

}  // namespace tessera
