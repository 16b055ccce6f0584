// A file here, as an upload on the server.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>

#include "src/base/result.h"
#include "src/service/client/server.h"

namespace tessera {

// Sends `file` as FOLDER/NAME, in place of what has that name there. A connection that ends is gone on with, within the
// server's patience. `on_bytes` is told how many have been sent. Gives the size. Errors: those of Server::upload(); io
// of the disk; usage when it is no file; io when it becomes shorter meanwhile.
Result<std::uint64_t> upload(Server& server, const std::filesystem::path& file, const std::string& folder,
                             const std::string& name, const std::function<void(std::uint64_t)>& on_bytes,
                             const std::stop_token& stop);

}  // namespace tessera
