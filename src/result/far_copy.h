// Copies whole results to object stores, and from there. The manifest is the last file that is written, so a result is
// there whole or not at all.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "src/base/result.h"
#include "src/result/far_files.h"
#include "src/result/store/tile_store.h"

namespace tessera::result {

// A file of a result: its name in the folder, and what the manifest says of it.
using NamedFile = std::pair<std::filesystem::path, ToldFile>;
// The master file, and those of duplicates.
std::vector<NamedFile> files_beside_tiles(const Manifest& manifest);

// The bytes that have arrived, and all bytes.
using TellBytes = std::function<void(std::uint64_t bytes, std::uint64_t bytes_total)>;

struct CopiedResult {
  std::uint64_t files = 0, bytes = 0;
  std::uint64_t vertices = 0, cells = 0, tiles = 0;
};

// Checks that a result may be written as `name` (s3://bucket/folder): the store can be asked and written, and has no
// result there unless `overwrite`. Errors: usage; those of check_writable_object().
Status check_far_target(const std::string& name, bool overwrite, const std::stop_token& stop);

// Copies the newest version of the finished result in `folder`, with its report, to a store. Each file is compared with
// the manifest before. With `overwrite` a result that is there is no result any more until the new one is whole; then
// files of it that the new one does not have are removed. Errors: those of check_far_target(), read_manifest() and
// put_objects(); corrupt.
Result<CopiedResult> put_result(const std::filesystem::path& folder, const std::string& name, bool overwrite,
                                const TellBytes& tell, const std::stop_token& stop);

// Copies a far result into a new or empty folder. Each file is compared with the manifest. After an error, what was
// copied is removed. Errors: usage for a folder that is not empty; io; those of reading a far result.
Result<CopiedResult> copy_far_result(const std::filesystem::path& name, const std::filesystem::path& folder,
                                     const TellBytes& tell, const std::stop_token& stop);

}  // namespace tessera::result
