// What `tessera triangulate` was asked to do, checked; no file has been touched yet.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "src/apps/command.h"
#include "src/apps/settings.h"
#include "src/base/result.h"
#include "src/io/cloud.h"
#include "src/kernel/kernel.h"
#include "src/tiling/partition.h"

namespace tessera {

struct TriangulateOptions {
  std::vector<std::string> inputs;
  std::filesystem::path out;
  CloudOptions cloud;
  PartitionKind partition = PartitionKind::kdtree;
  std::uint64_t max_points_per_tile = 0;  // 0: chosen from memory and threads, unless `tiles` is given
  std::uint32_t tiles = 0;
  std::uint32_t threads = 1;
  std::uint64_t memory_bytes = 0;
  KernelKind kernel = KernelKind::flat;
  bool neighbors = true, resume = false, overwrite = false;
  OutputOptions output;
};

// Options that say what the cloud and the tiles are: `info` has them too.
void add_cloud_options(Command& command);
Status read_cloud_options(Settings& settings, TriangulateOptions& options);

void add_triangulate_options(Command& command);
Result<TriangulateOptions> read_triangulate_options(Settings& settings, std::vector<std::string> inputs);

// Whether the points come from standard input, which cannot be read again.
bool reads_standard_input(const TriangulateOptions& options);

// Equal keys = the same result: everything above that it depends on, as text.
std::string options_key(const TriangulateOptions& options);

constexpr std::uint32_t threads_max = 1024;
constexpr std::uint64_t tiles_max = 1'000'000;  // file names have six digits

}  // namespace tessera
