// Uploads a file to the server.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>

#include "src/base/result.h"
#include "src/service/client/server.h"

namespace tessera::client {

// Sends `file` as FOLDER/NAME, and replaces a file of that name. If the connection ends, continues within the server's
// patience. `on_bytes` gets the number of bytes sent so far. Returns the size. Errors: those of Server::upload(); io of
// the disk; usage when it is no file; io when the file becomes shorter meanwhile.
Result<std::uint64_t> upload(Server& server, const std::filesystem::path& file, const std::string& folder,
                             const std::string& name, const std::function<void(std::uint64_t)>& on_bytes,
                             const std::stop_token& stop);

}  // namespace tessera::client
