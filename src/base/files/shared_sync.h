// One folder that many threads put new names into: those that wait at the same time share one sync.
#pragma once

#include <condition_variable>
#include <filesystem>
#include <memory>
#include <mutex>

#include "src/base/result.h"

namespace tessera {

class SharedSync {
 public:
  explicit SharedSync(std::filesystem::path folder) : folder_(std::move(folder)) {}

  // The names that were in the folder before the call are there for good when this returns without error.
  Status sync();

 private:
  struct Batch {
    bool done = false;
    Status status = success();
  };

  const std::filesystem::path folder_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::shared_ptr<Batch> next_ = std::make_shared<Batch>();  // whoever comes now is in this one
  bool syncing_ = false;                                     // the batch before
};

}  // namespace tessera
