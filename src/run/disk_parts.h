// Parts of jobs whose points stand in run folders: what nodes of production host.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "src/run/part.h"
#include "src/tiling/routed_run.h"

namespace tessera {

class DiskParts final : public PartSource {
 public:
  // `scratch`: where parts of a cluster's jobs put tiles that are not in memory, each in a folder of its own; none:
  // such parts are refused.
  explicit DiskParts(std::filesystem::path scratch = {}) : scratch_(std::move(scratch)) {}
  // A run that this process has in memory need not be read again. Until withdraw().
  void offer(std::shared_ptr<const RoutedRun> run);
  void withdraw(const RoutedRun& run) noexcept;

  Result<std::unique_ptr<Part>> open(const PartSpec& spec, NodeId self) override;

 private:
  const std::filesystem::path scratch_;
  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<const RoutedRun>> offered_;  // by folder
};

// Writes down that all tiles of a run were quiet and are independent of each other now; or that they are not, and then
// what made them so goes.
// `lock_file` as in PartOptions.
Status mark_settled(const RoutedRun& run, const std::filesystem::path& lock_file, bool settled);

}  // namespace tessera
