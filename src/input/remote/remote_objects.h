// The objects that a process reads by HTTP.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "src/input/bytes/objects.h"
#include "src/input/remote/permits.h"
#include "src/input/remote/s3.h"

namespace tessera::remote {

struct RemoteOptions {
  S3Options s3 = {};
  std::string ca_file = {};           // certificates (PEM) that https trusts; empty: those of the system
  std::filesystem::path folder = {};  // where bytes are kept; empty: the system's temporary folder
  std::uint64_t kept_bytes_max = std::uint64_t{1} << 30;  // of all objects; at least 64 MiB
  // For a process that reads what strangers name. Null: everything may be asked.
  std::shared_ptr<const Permits> permits = {};
};

// The file of certificates that variables name, as the command curl reads them; empty if none does. `variable` returns
// null for a variable that is not set.
std::string ca_file_of(const std::function<const char*(const char*)>& variable);

// For set_objects(). Threads and connections begin with the first object that is opened.
std::shared_ptr<Objects> remote_objects(RemoteOptions options);

}  // namespace tessera::remote
