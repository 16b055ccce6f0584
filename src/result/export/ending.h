// Checks names of files to write.
#pragma once

#include <cctype>
#include <filesystem>
#include <string>

#include "src/base/files/there.h"
#include "src/base/option.h"
#include "src/base/result.h"

namespace tessera::exports {

// The file's ending in lower case, with its dot.
inline std::string ending_of(const std::filesystem::path& target) {
  std::string ending = target.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending;
}

// Error usage when the target is a folder, or a file that may not be overwritten.
inline Status check_free(const std::filesystem::path& target, bool overwrite) {
  BOOST_OUTCOME_TRY(found, look_at(target));
  if (found && S_ISDIR(found->st_mode)) return error(Errc::usage, target.string() + ": is a folder");
  if (found && !overwrite)
    return error(Errc::usage, target.string() + ": exists already; " + option("overwrite", "true") + " replaces it");
  return success();
}

}  // namespace tessera::exports
