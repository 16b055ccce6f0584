#include "src/service/processes/disk_watch.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <system_error>
#include <utility>
#include <vector>

#include "src/base/files/descriptor.h"
#include "src/base/files/folder.h"
#include "src/base/files/there.h"
#include "src/base/thread_name.h"

namespace tessera::service {
namespace {

using std::chrono::steady_clock;

// The bytes that the files below the folder take on disk. Files that vanish meanwhile count as nothing, and so do files
// with another name elsewhere: the job has not written them.
Result<std::uint64_t> bytes_below(const std::filesystem::path& folder) {
  std::uint64_t bytes = 0;
  std::vector<std::filesystem::path> folders{folder};
  while (!folders.empty()) {
    const auto here = std::move(folders.back());
    folders.pop_back();
    FolderReader reader(here);
    while (const char* name = reader.next()) {
      BOOST_OUTCOME_TRY(found, look_at(here / name, FollowLinks::no));
      if (!found) continue;
      if (S_ISDIR(found->st_mode)) folders.push_back(here / name);
      constexpr std::uint64_t block_bytes = 512;  // unit of st_blocks on all file systems
      if (S_ISREG(found->st_mode) && found->st_nlink == 1)
        bytes += static_cast<std::uint64_t>(found->st_blocks) * block_bytes;
    }
    if (reader.error() && reader.error() != std::errc::no_such_file_or_directory)
      return io_error(here, "cannot be listed", reader.error().value());
  }
  return bytes;
}

}  // namespace

DiskWatch::DiskWatch(std::filesystem::path folder, Ledger& ledger)
    : folder_(std::move(folder)), ledger_(ledger), thread_([this](const std::stop_token& done) {
        name_thread("disk");
        std::mutex mutex;
        std::condition_variable_any ended;
        std::unique_lock lock(mutex);
        while (!done.stop_requested()) {
          const auto began = steady_clock::now();
          // What cannot be measured now may be the next time; finish() reports errors.
          static_cast<void>(look());
          if (!ledger_.go_on()) return;
          constexpr steady_clock::duration least = std::chrono::seconds(1);
          const auto pause = std::max(least, (steady_clock::now() - began) * 20);
          ended.wait_for(lock, done, pause, [&] { return done.stop_requested(); });
        }
      }) {}

Status DiskWatch::look() const {
  BOOST_OUTCOME_TRY(bytes, bytes_below(folder_));
  return ledger_.written_by_others(bytes);
}

Status DiskWatch::finish() {
  thread_.request_stop();
  thread_.join();
  return look();
}

}  // namespace tessera::service
