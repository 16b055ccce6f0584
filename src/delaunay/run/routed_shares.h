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

#include "src/exchange/share.h"
#include "src/result/store/tile_taker.h"
#include "src/tiling/routed_cloud.h"

namespace tessera {

class RoutedShares final : public ShareSource {
 public:
  // `scratch`: where parts of a cluster's jobs put tiles that are not in memory, each in a folder of its own; none:
  // such parts are refused.
  explicit RoutedShares(std::filesystem::path scratch = {}) : scratch_(std::move(scratch)) {}
  // A run that this process has in memory need not be read again. `taker`: gets its tiles' cells, which are not stored
  // then; or null. Until withdraw().
  void offer(std::shared_ptr<const RoutedCloud> run, TileConsumer* taker);
  void withdraw(const RoutedCloud& run) noexcept;

  Result<std::unique_ptr<Share>> open(const ShareSpec& spec, NodeId self) override;

 private:
  struct DiskShare;

  const std::filesystem::path scratch_;
  std::mutex mutex_;
  struct Offer {
    std::shared_ptr<const RoutedCloud> run;
    TileConsumer* taker = nullptr;
  };
  std::map<std::string, Offer> offered_;  // by folder
};

// What a run has stored, of the tiles that are wanted.
Result<std::vector<TileReceipt>> receipts_of(const std::filesystem::path& out,
                                             const std::function<bool(TileId)>& wanted);

}  // namespace tessera
