// Downloads a result from the server into a result folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>

#include "src/base/result.h"
#include "src/result/store/tile_store.h"
#include "src/service/client/server.h"

namespace tessera::client {

// Error corrupt when the server's answer is no manifest.
Result<Manifest> fetch_manifest(Server& server, const std::string& triangulation, const std::stop_token& stop);

struct FetchProgress {
  std::uint64_t bytes = 0, bytes_total = 0;  // including those that were there before
};

struct Fetched {
  std::uint64_t files = 0, bytes = 0;  // of the result
  std::uint64_t vertices = 0, cells = 0, tiles = 0;
};

// Makes `folder` a copy of the result. The manifest gets its name when all files are there and have their checksums.
// `folder` may be missing, empty, an interrupted download, or the same result; of the latter, damaged and missing files
// are downloaded again. After an error, an unfinished download stays and can be continued. Errors: those of Server;
// usage when `folder` holds something else or another process works in it; io of the disk; corrupt when the files are
// not what the manifest says.
Result<Fetched> fetch_result(Server& server, const std::string& triangulation, const std::filesystem::path& folder,
                             const std::function<void(const FetchProgress&)>& on_progress, const std::stop_token& stop);

}  // namespace tessera::client
