// Parts of jobs whose points stand in run folders: what nodes of production host.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "src/exchange/part.h"
#include "src/run/next_stage.h"
#include "src/store/tile_taker.h"
#include "src/tiling/routed_run.h"

namespace tessera {

class DiskParts final : public PartSource {
 public:
  // `scratch`: where parts of a cluster's jobs put tiles that are not in memory, each in a folder of its own; none:
  // such parts are refused. `next`: the stages that follow the triangulation.
  explicit DiskParts(std::filesystem::path scratch = {}, NextStages next = {})
      : scratch_(std::move(scratch)), next_(std::move(next)) {}
  // A run that this process has in memory need not be read again. `taker`: gets its tiles' cells, which are not stored
  // then; or null. Until withdraw().
  void offer(std::shared_ptr<const RoutedRun> run, TileTaker* taker);
  void withdraw(const RoutedRun& run) noexcept;

  Result<std::unique_ptr<Part>> open(const PartSpec& spec, NodeId self) override;

 private:
  struct DiskPart;
  void add_later_stages(DiskPart& part, const PartSpec& spec, NodeId self) const;

  const std::filesystem::path scratch_;
  const NextStages next_;
  std::mutex mutex_;
  struct Offer {
    std::shared_ptr<const RoutedRun> run;
    TileTaker* taker = nullptr;
  };
  std::map<std::string, Offer> offered_;  // by folder
};

// What a stage of a run has stored, of the tiles that are wanted.
Result<std::vector<TileReceipt>> stored_by(const NextStages& next, const std::filesystem::path& out,
                                           std::uint32_t stage, const std::function<bool(TileId)>& wanted);

}  // namespace tessera
