// Inputs that come from clients: a file is there under its name when it is whole, not before.
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

#include "src/service/service.h"
#include "src/service/staging_folder.h"

namespace tessera {

struct UploadLimits {
  std::uint64_t bytes = 0;          // of all uploads together; 0: what the disk has
  std::uint64_t files = 100'000;    // whole ones and parts
  std::uint64_t reserve_bytes = 0;  // of the disk, that uploads leave free
};

class Uploads {
 public:
  // `desk`: of uploads, over which a whole file gets its name, and goes.
  Uploads(std::filesystem::path data, const UploadLimits& limits, StagingFolder& desk);
  // Makes the folder. Error io.
  Status open();
  std::filesystem::path folder() const;

  // Goes on at `offset`, which must be what uploaded() says: 409. 400 for names that do not fit, 409 while the same
  // file is being sent by another, 507 over the limit. A file that is there already is replaced when the new one is
  // whole; 403 for that of another, and for what has come of it.
  Reply<std::unique_ptr<Service::Upload>> begin(std::string_view folder, std::string_view file, std::uint64_t offset,
                                                const Caller& caller);
  // Bytes of it that have come: of the part, or of the whole file. 404 for neither.
  Reply<std::uint64_t> uploaded(std::string_view folder, std::string_view file) const;

  // The file, what has come of it, and the folder when nothing else is in it. 404 for neither, 409 while it is sent,
  // 403 for that of another.
  Reply<void> remove(std::string_view folder, std::string_view file, const Caller& caller);
  // Removes parts to which nothing has come since; a sentence for each.
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
  // Of the file, or of what has come of it; none when there is neither.
  Result<std::optional<std::string>> owner_or_none(const std::filesystem::path& path) const;
  // Whether there was one.
  Result<bool> remove_one(const std::filesystem::path& file);
  Result<bool> expire_one(const std::filesystem::path& part, std::chrono::system_clock::time_point before);

  std::filesystem::path data_;
  UploadLimits limits_;
  StagingFolder& desk_;
  std::mutex mutex_;
  std::set<std::filesystem::path> active_;
  Used used_;
};

}  // namespace tessera
