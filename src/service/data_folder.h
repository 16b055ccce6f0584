// The data folder of a service, held: its lock, its term, and the desks over which it is changed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "src/base/files/folder_lock.h"
#include "src/base/result.h"
#include "src/service/staging_folder.h"

namespace tessera {

struct ServiceOptions;

class DataFolder {
 public:
  // Makes what is missing, waits for the lock as `options` say, notes the format where there is none, and ends the time
  // of whoever held the folder before. Errors: corrupt for a folder of a newer version; io, also when another process
  // is at work in it.
  static Result<std::unique_ptr<DataFolder>> hold(const ServiceOptions& options);

  // Each daemon that has held the folder has another one, the later the greater.
  std::uint64_t term() const { return jobs_->term(); }
  // Error io when another process holds the folder now, or it is gone.
  Status still_ours() const { return lock_.check(); }
  // The same by the clock alone, most of the time: for who asks often.
  Status heard() const { return lock_.heard(); }
  // For jobs, events and all else; for results, which may be on another disk; for uploads likewise.
  StagingFolder& desk() { return *jobs_; }
  StagingFolder& desk_of_results() { return *results_; }
  StagingFolder& desk_of_uploads() { return *uploads_; }

 private:
  explicit DataFolder(FolderLock lock) : lock_(std::move(lock)) {}

  FolderLock lock_;  // first: the desks ask it
  std::unique_ptr<StagingFolder> jobs_, results_, uploads_;
};

}  // namespace tessera
