// Jobs over the tiles of a result: stages of the exchange, one after the other, that make something of it.
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

// What the programs of a node's tiles may use. All of it outlives them.
struct ResultInput {
  TileSource source;
  std::filesystem::path run;        // what all nodes see: what the job is to do, and what stages leave
  std::filesystem::path own;        // of this node alone
  std::span<const std::byte> plan;  // the bytes of plan_file(run)
  std::uint64_t seal = 0;           // tells the run from all others: what is put on scratch says it
  NodeId node;
  std::uint64_t memory_bytes = 0;  // for what stays in memory of tiles that nobody works on
  std::stop_token stop;            // once requested, long work soon throws Stopped
};

// A kind of such jobs. Every process that works on them has one. Called from several threads.
class ResultStages {
 public:
  virtual ~ResultStages() = default;
  virtual std::uint32_t count() const = 0;
  // By stage. Error corrupt when the plan is not what such a job has.
  virtual Result<std::vector<std::shared_ptr<const TilePrograms>>> programs(const ResultInput& input) const = 0;
  // Of the tiles that have come to the end of a stage, whichever node they were on: they are not worked on again.
  virtual Result<std::vector<TileReceipt>> stored(const std::filesystem::path& run, std::uint32_t stage) const = 0;
  // What tile number `i` takes while it is worked on.
  virtual std::uint64_t work_bytes(const TileSource& source, std::size_t i) const = 0;
};
using KindsOfStages = std::map<std::string, std::shared_ptr<const ResultStages>>;  // by ShareSpec::stages

// The job's plan stands in plan_file(run).
struct ResultJob {
  std::string kind;
  std::filesystem::path result, run;
  ShareOptions options;
};

// ResultInput::seal of a run with this plan.
std::uint64_t seal_of_plan(std::span<const std::byte> plan);
// By tile, whether it has points or not: its own points.
std::vector<std::uint64_t> weights_of(const TileSource& source);
// What a point of the tile that takes most takes while it is worked on.
std::uint64_t bytes_a_point(const ResultStages& stages, const TileSource& source);

}  // namespace tessera
