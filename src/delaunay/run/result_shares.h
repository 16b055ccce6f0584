// Opens a node's shares of jobs over the tiles of results (result_stages.h), in production.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "src/delaunay/run/result_stages.h"
#include "src/exchange/share.h"

namespace tessera {

// A source of shares of jobs over results. Thread-safe.
class ResultShares final : public ShareSource {
 public:
  // `scratch`: as in RoutedShares.
  ResultShares(std::filesystem::path scratch, KindsOfStages kinds)
      : scratch_(std::move(scratch)), kinds_(std::move(kinds)) {}
  const KindsOfStages& kinds() const { return kinds_; }
  // Error internal when there is no such kind.
  Result<std::shared_ptr<const ResultStages>> kind(const std::string& name) const;
  // Each share of the run keeps `keeper` alive. Valid until withdraw().
  void offer(const std::filesystem::path& run, std::shared_ptr<const void> keeper);
  void withdraw(const std::filesystem::path& run) noexcept;

  Result<std::unique_ptr<Share>> open(const ShareSpec& spec, NodeId self) override;

 private:
  const std::filesystem::path scratch_;
  const KindsOfStages kinds_;
  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<const void>> keepers_;  // by run
};

}  // namespace tessera
