// The files of a cloud in EPT beside its ept.json, on this machine or on a server.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <span>
#include <string>

#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"
#include "src/input/bytes/far_source.h"

namespace tessera::ept {

// How many files are worth bringing at a time.
inline constexpr std::size_t files_at_once = 16;

// Files on a server stay open, the last few thousand, so that a second reading of a tile is of the same version and
// fetches nothing that is still kept. Thread-safe. Errors: those of opening and reading.
class Files {
 public:
  // Opens a file. `ept`: the source of ept.json.
  Result<std::unique_ptr<ByteSource>> open(const ByteSource& ept, const std::filesystem::path& path) const;
  // Opens and fetches files on a server that are not open yet, files_at_once at a time. Does nothing on this machine.
  Status bring(const ByteSource& ept, std::span<const std::filesystem::path> paths) const;

 private:
  bool knows(const std::string& name) const;
  // Fetches a file, unless it is open. Waits for a thread that fetches the same file.
  Result<std::shared_ptr<const ByteSource>> fetch(const FarSource& ept, const std::string& name) const;
  void keep(const std::string& name, std::shared_ptr<const ByteSource> file) const;

  mutable std::mutex mutex_;
  mutable std::condition_variable arrived_;
  mutable std::set<std::string> under_way_;
  mutable std::map<std::string, std::shared_ptr<const ByteSource>> open_;
  mutable std::deque<std::string> order_;  // in which they were opened
};

}  // namespace tessera::ept
