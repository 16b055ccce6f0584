// Routes the input as input splits, several at once, on every node that can read them.
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

// Routes the input splits of a cloud. The actors implement it for the nodes of a job.
class SplitRouter {
 public:
  virtual ~SplitRouter() = default;
  // Returns how many points an input split should have, for a cloud of `total` points.
  virtual std::uint64_t split_points(std::uint64_t total) const = 0;
  // Returns when route_split() has routed all input splits into the run folder. The result has, by input split, the
  // attempt that counts. Attempts begin at 1. Adds to progress.points_routed.
  virtual Result<std::vector<std::uint32_t>> route(const Cloud& cloud, const std::vector<InputSplit>& splits,
                                                   const Partition& partition, const std::filesystem::path& run_folder,
                                                   Progress& progress, const std::stop_token& stop) = 0;
};

class TileWriter;

// Is called with the number of further points that have been routed.
using RoutedMore = std::function<void(std::uint64_t)>;

struct SplitWork {
  std::filesystem::path run_folder;
  std::uint32_t attempt = 0;  // unique to this work: no other work on the run has this attempt
  std::uint64_t memory_bytes = 0;
  RoutedMore routed = [](std::uint64_t) {};
};

// Routes an input split into shuffle files, and writes down what is known of its points as one file, which is there as
// a whole or not at all.
Status route_split(const Cloud& cloud, const InputSplit& split, const Partition& partition, const SplitWork& work,
                   const std::stop_token& stop);
// The first half of route_split(): the points are then in shuffle files of `writer`, and what is known of them is in
// writer.routed().
Status write_split(const Cloud& cloud, const InputSplit& split, const Partition& partition, TileWriter& writer,
                   const std::stop_token& stop, const RoutedMore& more);
// Reads what route_split() has written down. Error io, corrupt.
Result<RoutedPoints> read_split(const std::filesystem::path& run_folder, std::uint32_t attempt,
                                const Partition& partition);

}  // namespace tessera
