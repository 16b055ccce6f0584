#include "src/api/temporary_folder.h"

#include <cerrno>
#include <cstdlib>
#include <string>
#include <system_error>
#include <utility>

namespace tessera {
namespace fs = std::filesystem;

Result<TemporaryFolder> TemporaryFolder::make() {
  std::error_code failed;
  const fs::path parent = fs::temp_directory_path(failed);
  if (failed) return error(Errc::io, "there is no temporary folder: " + failed.message());
  std::string name = (parent / "tessera-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr)
    return error(Errc::io, name + ": cannot be made: " + std::generic_category().message(errno));
  return TemporaryFolder(name);
}

TemporaryFolder::TemporaryFolder(TemporaryFolder&& other) noexcept : path_(std::exchange(other.path_, {})) {}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;  // a destructor cannot tell, and nobody waits for it
  if (!path_.empty()) fs::remove_all(path_, ignored);
}

}  // namespace tessera
