// Downloads a file of a result from the server.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include "src/base/files/checksum.h"
#include "src/base/result.h"
#include "src/service/client/server.h"

namespace tessera::client {

struct RemoteFile {
  std::string triangulation;
  std::string path;  // in the result: "tiles/000042.vtu"
  // From the manifest, or from the job that wrote the file. A partial download without a checksum is not continued.
  std::optional<std::uint64_t> bytes, xxh3;
  ChecksumOf sum = ChecksumOf::bytes;  // how xxh3 is computed
  bool in_manifest = true;             // then its ETag is its checksum
};

// Downloads to temporary_name(to), then syncs the file and renames it to `to` when it is complete and has its checksum.
// An existing partial file is continued. After an error the partial file stays, so that a later call can continue it,
// unless its bytes are wrong. If the server goes away, waits for it as long as its patience says; the server must have
// answered before. `on_bytes` gets the number of bytes, those of the partial file included. Errors: those of
// Server::file(); io of the disk; corrupt when the file has the wrong length or checksum.
Status download(Server& server, const RemoteFile& file, const std::filesystem::path& to,
                const std::function<void(std::uint64_t)>& on_bytes, const std::stop_token& stop);

}  // namespace tessera::client
