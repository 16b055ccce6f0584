// Looks for files below a folder by name, and joins names to paths.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "src/base/files/descriptor.h"
#include "src/base/result.h"

namespace tessera::service {

enum class KindBeneath : std::uint8_t { file, folder, other };

struct FoundBeneath {
  KindBeneath kind = KindBeneath::other;
  std::filesystem::path real;
  std::uint64_t bytes = 0;
  std::int64_t modified_s = 0;  // since 1970
};

// Returns nothing when the file does not exist. Does not open the file for reading. Errors: usage when the path leads
// out of the root; io.
Result<std::optional<FoundBeneath>> look_for(const FileHandle& root, const std::string& path);

// The names in a folder below `root`, without those that begin with a dot. Errors: as look_for(); those of the thread's
// ledger, from which each name is drawn.
Result<std::vector<std::string>> names_in(const FileHandle& root, const std::string& folder);

std::string below(const std::string& folder, const std::string& name);
// True if one of the path's parts is "..".
bool goes_up(const std::string& path);
// `path` relative to `folder`, when it is absolute and below the folder.
std::optional<std::string> from_folder(const std::string& path, const std::filesystem::path& folder);

}  // namespace tessera::service
