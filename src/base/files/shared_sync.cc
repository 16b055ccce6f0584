#include "src/base/files/shared_sync.h"

#include "src/base/files/whole_file.h"

namespace tessera {

Status SharedSync::sync() {
  std::unique_lock lock(mutex_);
  const auto batch = next_;
  changed_.wait(lock, [&] { return batch->done || !syncing_; });
  if (batch->done) return batch->status;
  // Made first: an exception after `syncing_ = true` would leave all waiting for ever.
  next_ = std::make_shared<Batch>();
  syncing_ = true;
  lock.unlock();
  Status status = success();
  try {
    status = sync_folder(folder_);
  } catch (const std::exception& thrown) {
    status = error(Errc::io, folder_.string() + ": cannot write: " + thrown.what());
  }
  lock.lock();
  batch->status = status;
  batch->done = true;
  syncing_ = false;
  changed_.notify_all();
  return status;
}

}  // namespace tessera
