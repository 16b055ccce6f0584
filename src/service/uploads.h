// Inputs that come from clients: a file is there under its name when it is whole, not before.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <string_view>

#include "src/service/desk.h"
#include "src/service/service.h"

namespace tessera {

class Uploads {
 public:
  // `bytes_max`: of all uploads together; 0: what the disk has. `desk`: of uploads, over which a whole file gets its
  // name.
  Uploads(std::filesystem::path data, std::uint64_t bytes_max, Desk& desk);
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

 private:
  class Sending;
  Reply<std::filesystem::path> path_of(std::string_view folder, std::string_view file) const;
  Result<std::uint64_t> used() const;

  std::filesystem::path data_;
  std::uint64_t bytes_max_;
  Desk& desk_;
  std::mutex mutex_;
  std::set<std::filesystem::path> active_;
  std::uint64_t used_ = 0;
};

}  // namespace tessera
