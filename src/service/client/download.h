// A file of a result on the server, as a file here.
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

namespace tessera {

struct RemoteFile {
  std::string triangulation;
  std::string path;  // in the result: "tiles/000042.vtu"
  // As its manifest, or the job that wrote it, has them; without checksum a file is not gone on with where it was cut.
  std::optional<std::uint64_t> bytes, xxh3;
  SumOf sum = SumOf::bytes;  // what xxh3 is of
  bool in_manifest = true;   // then its ETag is its checksum
};

// Bytes go to temporary_name(to), which is synced and renamed to `to` when it is whole and has its checksum; what is
// there of it, from before or from a connection that ended, is gone on with. It stays when the download fails, so that
// another can go on, unless its bytes are wrong. A server that goes away is waited for, as its patience says; so one
// must have been heard before. `on_bytes` is told of bytes as they come, and of those that were
// there. Errors: those of Server::file(), io of the disk, corrupt when what came has not the length or checksum.
Status download(Server& server, const RemoteFile& file, const std::filesystem::path& to,
                const std::function<void(std::uint64_t)>& on_bytes, const std::stop_token& stop);

}  // namespace tessera
