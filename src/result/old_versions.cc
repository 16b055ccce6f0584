#include "src/result/old_versions.h"

#include <algorithm>
#include <string>

#include "src/base/files/folder.h"
#include "src/base/files/names.h"
#include "src/base/files/there.h"

namespace tessera::result {

namespace fs = std::filesystem;

Result<std::vector<OldVersion>> old_versions(const fs::path& out) {
  std::vector<OldVersion> found;
  const auto folder = versions_folder(out);
  BOOST_OUTCOME_TRY(there, is_folder(folder, FollowLinks::no));
  if (!there) return found;
  BOOST_OUTCOME_TRY(names, sorted_names(folder));
  for (const std::string& name : names) {
    const auto version = version_of_file(name);
    if (version) found.push_back({*version, folder / name, name != version_file("", *version).filename()});
  }
  std::ranges::stable_sort(found, {}, &OldVersion::version);
  return found;
}

std::set<fs::path> tile_names(const Manifest& manifest) {
  std::set<fs::path> names;
  for (const auto& entry : manifest.tiles) names.insert(tile_file("", entry).filename());
  return names;
}

}  // namespace tessera::result
