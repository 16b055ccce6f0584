// A stage that a job runs after its triangulation: programs over the tiles that are stored by then.
#pragma once

#include <filesystem>
#include <memory>
#include <stop_token>
#include <vector>

#include "src/base/result.h"
#include "src/exchange/tile_program.h"
#include "src/exchange/tile_storage.h"
#include "src/tiling/routed_run.h"

namespace tessera {

// What the programs of a node's tiles may use. All of it outlives them.
struct StageInput {
  std::shared_ptr<const RoutedRun> run;
  std::filesystem::path out;       // the result folder: the triangulation's tiles stand in it
  TileStorage* scratch = nullptr;  // of this stage
  std::stop_token stop;            // once requested, long work soon throws Stopped
};

// Every process that works on the job has one. Called from several threads.
class NextStage {
 public:
  virtual ~NextStage() = default;
  virtual std::shared_ptr<const TilePrograms> programs(const StageInput& input) = 0;
  // Of the tiles that have come to the end of the stage, whoever they were on: they are not worked on again.
  virtual Result<std::vector<TileReceipt>> stored(const std::filesystem::path& out) = 0;
};
using NextStages = std::vector<std::shared_ptr<NextStage>>;

// How many stages of a run are settled, of so many: the first of those that are not goes on, or begins. Error io.
Result<std::uint32_t> settled_stages(const std::filesystem::path& run, std::uint32_t stages);
// Writes down that all tiles were quiet in a stage and are independent of each other now; or that they are not, and
// then what made them so goes. `lock_file` as in PartOptions.
Status mark_settled(const std::filesystem::path& run, std::uint32_t stage, const std::filesystem::path& lock_file,
                    bool settled);

}  // namespace tessera
