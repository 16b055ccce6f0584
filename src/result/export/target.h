// Checks where an export goes, before anything is read.
#pragma once

#include <filesystem>

#include "src/base/result.h"
#include "src/result/export/export.h"
#include "src/result/export/formats.h"
#include "src/result/store/tile_store.h"

namespace tessera::exports {

// The target of an export: a file or a folder.
struct Target {
  const Format* format = nullptr;
  std::filesystem::path path;
  bool folder = false;
};

// Returns those of the errors usage of export_result() that need no result.
Result<Target> find_free_target(const std::filesystem::path& path, const ExportOptions& options);

// The format with this name, or if `name` is empty, the format of the target's ending. Error usage when there is none.
Result<const Format*> find_format(const std::filesystem::path& target, const std::string& name);

// The index file beside the exported file, if the format has one.
std::filesystem::path index_beside(const Target& target);

// Error usage when the format cannot hold the result.
Status check_fits(const std::filesystem::path& out, const Manifest& manifest, const Format& format);

}  // namespace tessera::exports
