#include "src/base/crs/proj_files.h"

#include <unistd.h>

#include <string>
#include <string_view>
#include <vector>

namespace tessera {
namespace {

std::vector<std::string>& own_folders() {
  static std::vector<std::string> folders;
  return folders;
}

// Returns the path of a file in PROJ's own folders. Never returns null, because PROJ would then search in its usual
// places. PROJ copies the text before it asks again on this thread.
const char* find_own(PJ_CONTEXT*, const char* name, void*) {
  static thread_local std::string found;
  const std::string_view plain(name);
  found.clear();  // an empty name, which no file has
  if (plain.empty() || plain.find('/') != std::string_view::npos) return found.c_str();
  for (const auto& folder : own_folders()) {
    found = folder + "/" + name;
    if (::access(found.c_str(), R_OK) == 0) return found.c_str();
  }
  found.clear();
  return found.c_str();
}

}  // namespace

void keep_to_own_files(const GdalLibrary& gdal) {
  const std::string writable = gdal.proj_context_get_user_writable_directory(nullptr, 0);
  char** const folders = gdal.OSRGetPROJSearchPaths();
  for (char** folder = folders; folder != nullptr && *folder != nullptr; ++folder)
    if (*folder != writable) own_folders().emplace_back(*folder);
  gdal.CSLDestroy(folders);
  gdal.proj_context_set_file_finder(nullptr, find_own, nullptr);
  gdal.OSRSetPROJEnableNetwork(0);
}

}  // namespace tessera
