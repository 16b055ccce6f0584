// Who holds a data folder now changes it; who held it before does not, however late a call of his comes.
//
// Each daemon that takes the lock of a data folder has a term, one more than all before (src/exchange/terms.h). In each
// area that it changes it has a desk, the folder AREA/.desk-TERM. Whatever appears in the area, is replaced or goes,
// passes over the desk, and takes its place by one rename from there. So does what a job has made, a folder.
//
//   write    a new file is written on the desk, and renamed to its name
//   move     a file or folder is renamed to the desk, and from there to its new name
//
// A successor first lays its own desk, then clears those of all terms before: what was under way goes back to where it
// came from, and the desk is removed. From then on every rename from it or to it fails, since there is no such folder,
// also when the process that tries it was stopped between its last look at the lock and the call. So nothing that is
// written with an older term ever counts, and this needs no clock. Of a file system it needs what a lock needs: renames
// and removals of folders that happen once, at the server.
//
// Each call asks first whether the lock is held (FolderLock::check()), so that a process which has lost it hears of
// that, and not of a folder that is missing.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string_view>

#include "src/base/result.h"

namespace tessera {

class StagingFolder {
 public:
  using StillOurs = std::function<Status()>;

  // `area` exists. Errors io, here and below, and corrupt when a desk of an earlier term holds what no desk does.
  static Result<std::unique_ptr<StagingFolder>> lay(std::filesystem::path area, std::uint64_t term,
                                                    StillOurs still_ours);
  StagingFolder(const StagingFolder&) = delete;
  StagingFolder& operator=(const StagingFolder&) = delete;
  ~StagingFolder();  // removes it

  // Atomic, and on the disk for good: under `final_name`, in the area, there is the old file or the whole new one.
  Status write(const std::filesystem::path& final_name, std::string_view text);
  // Both in the area. Where `to` is an empty folder or a file, it is replaced. Not synced.
  Status move(const std::filesystem::path& from, const std::filesystem::path& to);
  // move() in two steps. What is picked up and never put down goes back when the desk is cleared.
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
  std::atomic<std::uint64_t> files_ = 0;  // that were written: names of their own
};

}  // namespace tessera
