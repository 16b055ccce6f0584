// Holds the data folder of a service: its lock, its term, and the staging folders for changes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "src/base/files/folder_lock.h"
#include "src/base/result.h"
#include "src/service/staging_folder.h"

namespace tessera::service {

struct ServiceOptions;

class DataFolder {
 public:
  // Makes what is missing, waits for the lock as `options` say, writes the format of a new folder, and takes over from
  // the daemon that held the folder before. Errors: corrupt for a folder of a newer version; io, also when another
  // process works in the folder.
  static Result<std::unique_ptr<DataFolder>> hold(const ServiceOptions& options);

  // The number of the daemon that holds the folder; later daemons have higher numbers.
  std::uint64_t term() const { return jobs_->term(); }
  // Error io when another process holds the folder now, or the folder is gone.
  Status still_ours() const { return lock_.check(); }
  // The same, mostly by the clock alone, for frequent calls.
  Status heard() const { return lock_.heard(); }
  // The staging folders: for jobs, events and everything else; for results, which may be on another disk; and for
  // uploads, which may be, too.
  StagingFolder& desk() { return *jobs_; }
  StagingFolder& desk_of_results() { return *results_; }
  StagingFolder& desk_of_uploads() { return *uploads_; }

 private:
  explicit DataFolder(FolderLock lock) : lock_(std::move(lock)) {}

  FolderLock lock_;  // first, because the staging folders use it
  std::unique_ptr<StagingFolder> jobs_, results_, uploads_;
};

}  // namespace tessera::service
