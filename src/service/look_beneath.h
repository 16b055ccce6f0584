// What there is below a folder, by names, and how the names go together.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "src/base/files/descriptor.h"
#include "src/base/result.h"

namespace tessera {

enum class KindBeneath : std::uint8_t { file, folder, other };

struct FoundBeneath {
  KindBeneath kind = KindBeneath::other;
  std::filesystem::path real;
  std::uint64_t bytes = 0;
  std::int64_t modified_s = 0;  // since 1970
};

// Nothing when nothing is there. Never opened for reading. Errors: usage when it leads out of the root; io.
Result<std::optional<FoundBeneath>> look_for(const FileHandle& root, const std::string& path);

// Names in a folder below `root`, those that begin with a dot left out. Errors as above; of the thread's ledger, from
// which each name is drawn.
Result<std::vector<std::string>> names_in(const FileHandle& root, const std::string& folder);

std::string below(const std::string& folder, const std::string& name);
// Whether one of its parts is "..".
bool goes_up(const std::string& path);
// `path` from `folder` on, when it is absolute and stands below it.
std::optional<std::string> from_folder(const std::string& path, const std::filesystem::path& folder);

}  // namespace tessera
