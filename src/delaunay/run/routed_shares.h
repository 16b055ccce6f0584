// Opens a node's shares of jobs whose points are in run folders, in production.
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

// A source of shares of triangulation jobs. Thread-safe.
class RoutedShares final : public ShareSource {
 public:
  // `scratch`: the folder for tiles of cluster jobs that are not in memory; each share gets a folder of its own in it.
  // Empty: shares of cluster jobs are refused.
  explicit RoutedShares(std::filesystem::path scratch = {}) : scratch_(std::move(scratch)) {}
  // Offers a run that this process has in memory, so that it need not be read again. `taker`: gets the tiles' cells,
  // which are then not stored; or null. Valid until withdraw().
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

// Returns the receipts of what a run has stored in `out`, of the tiles that are wanted.
Result<std::vector<TileReceipt>> receipts_of(const std::filesystem::path& out,
                                             const std::function<bool(TileId)>& wanted);

}  // namespace tessera
