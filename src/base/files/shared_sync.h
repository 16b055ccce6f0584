// Syncs a folder into which many threads put new names. Threads that wait at the same time share one sync.
#pragma once

#include <condition_variable>
#include <filesystem>
#include <memory>
#include <mutex>

#include "src/base/result.h"

namespace tessera {

// Thread-safe.
class SharedSync {
 public:
  explicit SharedSync(std::filesystem::path folder) : folder_(std::move(folder)) {}

  // When this returns without error, the names that were in the folder before the call survive a power cut.
  Status sync();

 private:
  struct Batch {
    bool done = false;
    Status status = success();
  };

  const std::filesystem::path folder_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::shared_ptr<Batch> next_ = std::make_shared<Batch>();  // the batch that a new caller joins
  bool syncing_ = false;                                     // whether the batch before next_ is being synced
};

}  // namespace tessera
