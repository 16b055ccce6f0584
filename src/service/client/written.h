// The files that a job has written beside a result, as files here.
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

namespace tessera {

struct WrittenFile {
  std::string path;    // below the result: "exports/tiles/000042.vtu"
  std::string inside;  // the same below exports: "tiles/000042.vtu"
  std::uint64_t bytes = 0, xxh3 = 0;
};

// Of what an export job found. Error corrupt when it does not say, or a path would lead elsewhere.
Result<std::vector<WrittenFile>> written_files(const nlohmann::ordered_json& outcome);

// Where they go here, in their order: nothing that a server says leads out of what was asked for. `made`: what the
// export is called there, a folder whose files keep their names in `folder`; or a file that becomes `target`, as do
// those beside it with its name and another of the `endings`. Error corrupt for files that are neither.
Result<std::vector<std::filesystem::path>> places_in_folder(const std::vector<WrittenFile>& files,
                                                            const std::string& made,
                                                            const std::filesystem::path& folder);
Result<std::vector<std::filesystem::path>> places_beside(const std::vector<WrittenFile>& files, const std::string& made,
                                                         const std::filesystem::path& target,
                                                         const std::set<std::string>& endings);

// Each to its place, instead of what is there, when it is whole and has its checksum; folders are made. What a fetch
// that was cut has left under the temporary names is gone on with. Errors: those of download().
// REQUIRES: as many places as files.
Status fetch_written(Server& server, const std::string& triangulation, const std::vector<WrittenFile>& files,
                     const std::vector<std::filesystem::path>& places,
                     const std::function<void(std::uint64_t bytes, std::uint64_t total)>& on_progress,
                     const std::stop_token& stop);

}  // namespace tessera
