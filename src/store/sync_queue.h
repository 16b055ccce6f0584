// Makes written tile files durable in the background: the disk syncs while the caller collects the next tile.
// A tile counts as stored only after its rename, which follows its sync.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <filesystem>
#include <map>
#include <mutex>
#include <string>
#include <thread>

#include "src/base/result.h"
#include "src/store/files.h"
#include "src/store/tile_store.h"

namespace tessera::store {

class SyncQueue {
 public:
  // The one queue of this process. Its thread starts with the first file; at exit, what was pushed is finished.
  static SyncQueue& instance();
  ~SyncQueue();

  // Takes over a fully written temporary file: to be synced, renamed to the tile's name, and its side file written.
  void push(const std::filesystem::path& out, TemporaryFile file, const TileEntry& entry);
  // Waits until every file of `out` pushed so far is stored; the first error since the last call.
  Status settle(const std::filesystem::path& out);
  // The first error of `out` so far, without waiting; it stays until settle() has told it.
  Status failed(const std::filesystem::path& out);

 private:
  struct Job {
    std::string out;
    TemporaryFile file;
    TileEntry entry;
  };
  void work();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Job> jobs_;
  std::map<std::string, std::size_t> unfinished_;  // by folder
  std::map<std::string, Error> errors_;            // by folder: the first one
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace tessera::store
