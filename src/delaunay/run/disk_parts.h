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
#include "src/result/store/tile_taker.h"
#include "src/tiling/routed_run.h"

namespace tessera {

class DiskParts final : public PartSource {
 public:
  // `scratch`: where parts of a cluster's jobs put tiles that are not in memory, each in a folder of its own; none:
  // such parts are refused.
  explicit DiskParts(std::filesystem::path scratch = {}) : scratch_(std::move(scratch)) {}
  // A run that this process has in memory need not be read again. `taker`: gets its tiles' cells, which are not stored
  // then; or null. Until withdraw().
  void offer(std::shared_ptr<const RoutedRun> run, TileTaker* taker);
  void withdraw(const RoutedRun& run) noexcept;

  Result<std::unique_ptr<Part>> open(const PartSpec& spec, NodeId self) override;

 private:
  struct DiskPart;

  const std::filesystem::path scratch_;
  std::mutex mutex_;
  struct Offer {
    std::shared_ptr<const RoutedRun> run;
    TileTaker* taker = nullptr;
  };
  std::map<std::string, Offer> offered_;  // by folder
};

// What a run has stored, of the tiles that are wanted.
Result<std::vector<TileReceipt>> receipts_of(const std::filesystem::path& out,
                                             const std::function<bool(TileId)>& wanted);

}  // namespace tessera
