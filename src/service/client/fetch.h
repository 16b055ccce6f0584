// A result on the server, as a result folder here.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>

#include "src/base/result.h"
#include "src/result/store/tile_store.h"
#include "src/service/client/server.h"

namespace tessera {

// Error corrupt when it is none.
Result<Manifest> fetch_manifest(Server& server, const std::string& triangulation, const std::stop_token& stop);

struct FetchProgress {
  std::uint64_t bytes = 0, bytes_total = 0;  // those that were there are among them
};

struct Fetched {
  std::uint64_t files = 0, bytes = 0;  // of the result
  std::uint64_t vertices = 0, cells = 0, tiles = 0;
};

// Makes `folder` the result folder of that name: its manifest is there under its name when all its files are, each with
// its checksum. `folder` may be missing, empty, what a fetch that was cut has left, or the same result, of which
// damaged and missing files are fetched again. What is there of an unfinished one stays after an error, and is gone on
// with. Errors: those of Server; usage when `folder` holds something else or another process works in it; io of the
// disk; corrupt when what came is not what the manifest says.
Result<Fetched> fetch_result(Server& server, const std::string& triangulation, const std::filesystem::path& folder,
                             const std::function<void(const FetchProgress&)>& on_progress, const std::stop_token& stop);

}  // namespace tessera
