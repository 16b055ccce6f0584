// Jobs over the tiles of a result: they compute something from it in one or more stages of the exchange.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/exchange/share.h"
#include "src/exchange/tile_program.h"
#include "src/result/tile_source.h"

namespace tessera {

// What the programs of a node's tiles may use. All of it outlives the programs.
struct ResultInput {
  TileSource source;
  std::filesystem::path run;        // run folder that all nodes see: what the job is to do, and what stages leave
  std::filesystem::path own;        // folder of this node alone
  std::span<const std::byte> plan;  // the bytes of plan_file(run)
  std::uint64_t seal = 0;           // tells the run from all others; what is put on scratch contains it
  NodeId node;
  std::uint64_t memory_bytes = 0;  // for tiles that stay in memory while no thread works on them
  std::stop_token stop;            // once requested, long work soon throws Stopped
  std::uint32_t threads = 1;
  std::uint64_t tile_bytes = 0;  // for the tiles of all stages, beside memory_bytes
};

// A kind of such jobs. Every process that works on these jobs has one. Thread-safe.
class ResultStages {
 public:
  virtual ~ResultStages() = default;
  // The number of stages.
  virtual std::uint32_t count() const = 0;
  // Returns the programs by stage. Error corrupt when the plan is not that of such a job.
  virtual Result<std::vector<std::shared_ptr<const TilePrograms>>> programs(const ResultInput& input) const = 0;
  // Returns the receipts of the tiles that have finished a stage, on whichever node; they are not worked on again.
  virtual Result<std::vector<TileReceipt>> stored(const std::filesystem::path& run, std::uint32_t stage) const = 0;
  // Returns how many bytes tile number `i` of the source takes while it is worked on.
  virtual std::uint64_t work_bytes(const TileSource& source, std::size_t i) const = 0;
  // Returns the number of points by tile, with 0 for tiles that take no part. `plan`: the bytes of plan_file(run).
  virtual Result<std::vector<std::uint64_t>> weights(const TileSource& source, const std::filesystem::path& run,
                                                     std::span<const std::byte> plan) const;
  // Says in the schedule what is special about these jobs.
  virtual void adjust(ScheduleOptions& /*schedule*/, const TileSource& /*source*/) const {}
};
using KindsOfStages = std::map<std::string, std::shared_ptr<const ResultStages>>;  // by ShareSpec::stages

// A job of such a kind. Its plan is in plan_file(run).
struct ResultJob {
  std::string kind;
  std::filesystem::path result, run;
  ShareOptions options;
};

// Returns ResultInput::seal of a run with this plan.
std::uint64_t seal_of_plan(std::span<const std::byte> plan);
// Returns the number of own points by tile, with 0 for tiles without points.
std::vector<std::uint64_t> weights_of(const TileSource& source);
// Returns the bytes per point of the tile that takes most per point while it is worked on.
std::uint64_t bytes_a_point(const ResultStages& stages, const TileSource& source);

}  // namespace tessera
