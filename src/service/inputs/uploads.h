// Receives input files from clients. A file gets its name only when it is complete.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "src/service/inputs/inputs_backend.h"
#include "src/service/staging_folder.h"

namespace tessera::service {

struct UploadLimits {
  std::uint64_t bytes = 0;          // of all uploads together; 0: what the disk has
  std::uint64_t files = 100'000;    // complete and partial files
  std::uint64_t reserve_bytes = 0;  // of the disk, that uploads leave free
};

class Uploads {
 public:
  // `desk` is the staging folder of uploads: complete files get their names, and are removed, through it.
  Uploads(std::filesystem::path data, const UploadLimits& limits, StagingFolder& desk);
  // Makes the folder. Error io.
  Status open();
  std::filesystem::path folder() const;

  // Continues a file at `offset`, which must be what uploaded() returned, else 409. 400 for invalid names; 409 while
  // another client sends the same file; 507 over the limit; 403 for a complete or partial file of another owner. An
  // existing file is replaced when the new one is complete.
  Reply<std::unique_ptr<Upload>> begin(std::string_view folder, std::string_view file, std::uint64_t offset,
                                       const Caller& caller);
  // The bytes of the file that have come, partial or complete. 404 when there is neither.
  Reply<std::uint64_t> uploaded(std::string_view folder, std::string_view file) const;

  // Removes the file, complete or partial, and its folder when that is empty then. 404 when there is no file; 409 while
  // it is being sent; 403 for a file of another owner.
  Reply<void> remove(std::string_view folder, std::string_view file, const Caller& caller);
  // Removes partial files to which nothing was added since `before`. Returns a sentence for each.
  std::vector<std::string> expire(std::chrono::system_clock::time_point before);

 private:
  class Sending;
  struct Used {
    std::uint64_t bytes = 0, files = 0;
  };
  Reply<std::filesystem::path> path_of(std::string_view folder, std::string_view file) const;
  Result<Used> used() const;
  // REQUIRES: `mutex_` is held, here and below.
  void gone(std::uint64_t bytes, bool file);
  // The owner of the file, complete or partial; nothing when there is no file.
  Result<std::optional<std::string>> owner_or_none(const std::filesystem::path& path) const;
  // Returns true if there was a file.
  Result<bool> remove_one(const std::filesystem::path& file);
  Result<bool> expire_one(const std::filesystem::path& part, std::chrono::system_clock::time_point before);

  std::filesystem::path data_;
  UploadLimits limits_;
  StagingFolder& desk_;
  std::mutex mutex_;
  std::set<std::filesystem::path> active_;
  Used used_;
};

}  // namespace tessera::service
