#include "src/service/inputs/look_beneath.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "src/base/files/folder.h"
#include "src/base/ledger.h"
#include "src/service/beneath.h"

namespace tessera::service {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t names_max = 1'000'000;

}  // namespace

Result<std::vector<std::string>> names_in(const FileHandle& root, const std::string& folder) {
  BOOST_OUTCOME_TRY(opened, open_beneath(root, folder, O_RDONLY | O_DIRECTORY, Links::followed_beneath));
  std::vector<std::string> names;
  FolderReader reader(path_of(opened));
  while (const char* name = reader.next()) {
    BOOST_OUTCOME_TRYV(Ledger::draw_files(1));
    if (name[0] != '.') names.emplace_back(name);
    if (names.size() > names_max) return error(Errc::usage, folder + ": holds more than a million files");
  }
  if (reader.error()) return error(Errc::io, folder + ": cannot be read: " + reader.error().message());
  return names;
}

std::string below(const std::string& folder, const std::string& name) {
  return folder == "." ? name : folder + "/" + name;
}

Result<std::optional<FoundBeneath>> look_for(const FileHandle& root, const std::string& path) {
  BOOST_OUTCOME_TRY(opened, open_if_there(root, path, O_PATH, Links::followed_beneath));
  if (!opened) return std::optional<FoundBeneath>();
  struct stat status {};
  if (::fstat(opened->get(), &status) != 0) return io_error(path, "cannot be looked at", errno);
  BOOST_OUTCOME_TRY(real, real_path(*opened));
  const KindBeneath kind = S_ISREG(status.st_mode)   ? KindBeneath::file
                           : S_ISDIR(status.st_mode) ? KindBeneath::folder
                                                     : KindBeneath::other;
  return std::optional(
      FoundBeneath{kind, std::move(real), static_cast<std::uint64_t>(status.st_size), status.st_mtim.tv_sec});
}

bool goes_up(const std::string& path) {
  const fs::path parts(path);
  return std::find(parts.begin(), parts.end(), "..") != parts.end();
}

std::optional<std::string> from_folder(const std::string& path, const fs::path& folder) {
  const std::string begin = folder.string() == "/" ? "/" : folder.string() + "/";
  if (path == folder.string()) return ".";
  if (!path.starts_with(begin)) return std::nullopt;
  return path.substr(begin.size());
}

}  // namespace tessera::service
