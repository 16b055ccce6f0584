// Downloads the files that a job has written beside a result.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <set>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/service/client/server.h"

namespace tessera::client {

struct WrittenFile {
  std::string path;    // below the result: "exports/tiles/000042.vtu"
  std::string inside;  // the same below exports: "tiles/000042.vtu"
  std::uint64_t bytes = 0, xxh3 = 0;
};

// The files in the outcome of an export job. Error corrupt when the outcome does not list them, or when a path would
// lead out of the folder.
Result<std::vector<WrittenFile>> written_files(const nlohmann::ordered_json& outcome);

// The local paths of the files, in their order. Nothing that a server says leads out of the target. `made` is the name
// of the export on the server: a folder, whose files keep their names in `folder`; or a file that becomes `target`, as
// do the files beside it with the same name and another of the `endings`. Error corrupt for other files.
Result<std::vector<std::filesystem::path>> places_in_folder(const std::vector<WrittenFile>& files,
                                                            const std::string& made,
                                                            const std::filesystem::path& folder);
Result<std::vector<std::filesystem::path>> places_beside(const std::vector<WrittenFile>& files, const std::string& made,
                                                         const std::filesystem::path& target,
                                                         const std::set<std::string>& endings);

// Downloads each file to its place, and replaces existing files; makes folders. A file gets its name when it is
// complete and has its checksum. Partial files of an interrupted download are continued. Errors: those of download().
// REQUIRES: as many places as files.
Status fetch_written(Server& server, const std::string& triangulation, const std::vector<WrittenFile>& files,
                     const std::vector<std::filesystem::path>& places,
                     const std::function<void(std::uint64_t bytes, std::uint64_t total)>& on_progress,
                     const std::stop_token& stop);

}  // namespace tessera::client
