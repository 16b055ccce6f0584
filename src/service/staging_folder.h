// Lets only the current holder of a data folder change it. Earlier holders cannot, however late their calls come.
//
// Each daemon that takes the lock of a data folder has a term, one more than all before (src/exchange/terms.h). In each
// area that it changes, it has a staging folder (a desk), AREA/.desk-TERM. Every file that appears in the area, is
// replaced or is removed passes through the desk, and gets its place by one rename from there. So do folders that jobs
// have made.
//
//   write    a new file is written on the desk, and renamed to its name
//   move     a file or folder is renamed to the desk, and from there to its new name
//
// A successor first makes its own desk, then clears the desks of all terms before: files under way go back to where
// they came from, and the desk is removed. From then on every rename from or to that desk fails, because the folder
// does not exist. That also holds for a process that was suspended between its last check of the lock and the rename.
// So nothing that is written with an older term ever takes effect, and this needs no clock. The file system must
// provide what a lock needs: renames and removals of folders that happen once, at the server.
//
// Each call first checks whether the lock is held (FolderLock::check()). So a process that has lost it gets that error,
// and not one about a missing folder.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string_view>

#include "src/base/result.h"

namespace tessera::service {

class StagingFolder {
 public:
  using StillOurs = std::function<Status()>;

  // Makes the desk. REQUIRES: `area` exists. Errors: io, here and below; corrupt when a desk of an earlier term holds
  // unknown files.
  static Result<std::unique_ptr<StagingFolder>> lay(std::filesystem::path area, std::uint64_t term,
                                                    StillOurs still_ours);
  StagingFolder(const StagingFolder&) = delete;
  StagingFolder& operator=(const StagingFolder&) = delete;
  ~StagingFolder();  // removes the desk

  // Writes a file in the area. Atomic and durable: `final_name` is either the old file or the complete new one.
  Status write(const std::filesystem::path& final_name, std::string_view text);
  // Both paths are in the area. An empty folder or a file at `to` is replaced. Not synced.
  Status move(const std::filesystem::path& from, const std::filesystem::path& to);
  // move() in two steps. A file that is picked up and never put down goes back when the desk is cleared.
  Result<std::filesystem::path> pick_up(const std::filesystem::path& from);
  Status put_down(const std::filesystem::path& picked_up, const std::filesystem::path& to);

  std::uint64_t term() const { return term_; }
  // Error io when another process holds the data folder now.
  Status still_ours() const { return still_ours_(); }

 private:
  StagingFolder(std::filesystem::path area, std::uint64_t term, StillOurs still_ours);
  Status clear(const std::filesystem::path& desk) const;
  Status put_back(const std::filesystem::path& picked_up) const;
  Status rename(const std::filesystem::path& from, const std::filesystem::path& to) const;

  const std::filesystem::path area_;
  const std::uint64_t term_;
  const StillOurs still_ours_;
  const std::filesystem::path desk_;
  std::atomic<std::uint64_t> files_ = 0;  // number of files written, for unique names
};

}  // namespace tessera::service
