// What a job is asked to do, whoever asks: the command or a program that uses the library.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "src/io/cloud/cloud.h"
#include "src/run/part.h"
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

constexpr std::uint32_t threads_max = 1024;
constexpr std::uint64_t tiles_max = 1'000'000;  // file names have six digits

}  // namespace tessera
