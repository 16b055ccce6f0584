// The input in stretches, which are routed at once, by whoever can read them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <vector>

#include "src/base/progress.h"
#include "src/base/result.h"
#include "src/input/cloud/cloud.h"
#include "src/tiling/partition.h"
#include "src/tiling/routed_points.h"

namespace tessera {

// Who routes the stretches of a cloud.
class SplitRouter {
 public:
  virtual ~SplitRouter() = default;
  // How many points a stretch should have, of so many in all.
  virtual std::uint64_t stretch_points(std::uint64_t total) const = 0;
  // Returns when all have been routed into the run folder, by route_split(): by stretch, the attempt that counts.
  // Attempts begin at 1. Adds to progress.points_routed.
  virtual Result<std::vector<std::uint32_t>> route(const Cloud& cloud, const std::vector<InputSplit>& splits,
                                                   const Partition& partition, const std::filesystem::path& run_folder,
                                                   Progress& progress, const std::stop_token& stop) = 0;
};

class TileWriter;

// Told that so many points more have been routed.
using RoutedMore = std::function<void(std::uint64_t)>;

struct SplitWork {
  std::filesystem::path run_folder;
  std::uint32_t attempt = 0;  // nobody else has this one
  std::uint64_t memory_bytes = 0;
  RoutedMore routed = [](std::uint64_t) {};
};

// Routes a stretch into bundles and writes down what is known of its points: as one file, whole or not there.
Status route_split(const Cloud& cloud, const InputSplit& split, const Partition& partition, const SplitWork& work,
                   const std::stop_token& stop);
// The first half of it: the points are in bundles of `writer`, what is known of them in its account.
Status write_stretch(const Cloud& cloud, const InputSplit& split, const Partition& partition, TileWriter& writer,
                     const std::stop_token& stop, const RoutedMore& more);
// What route_split() has written down. Error io, corrupt.
Result<RoutedPoints> read_stretch(const std::filesystem::path& run_folder, std::uint32_t attempt,
                                  const Partition& partition);

}  // namespace tessera
