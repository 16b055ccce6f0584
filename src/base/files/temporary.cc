#include "src/base/files/temporary.h"

#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <new>
#include <string>
#include <system_error>

#include "src/base/files/descriptor.h"
#include "src/base/files/folder.h"

namespace tessera {

namespace fs = std::filesystem;

TemporaryFile::~TemporaryFile() {
  if (!path_.empty() && process_ == ::getpid()) ::unlink(path_.c_str());
}

Result<fs::path> folder_for_temporary(fs::path wished) {
  if (!wished.empty()) return wished;
  std::error_code failed;
  fs::path folder = fs::temp_directory_path(failed);
  if (failed) return error(Errc::io, "the system's temporary folder: " + failed.message());
  return folder;
}

Result<TemporaryFolder> TemporaryFolder::make() {
  BOOST_OUTCOME_TRY(parent, folder_for_temporary());
  std::string name = (parent / "tessera-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) return io_error(name, "cannot be made", errno);
  try {
    return TemporaryFolder(name);
  } catch (const std::bad_alloc&) {
    ::rmdir(name.c_str());
    throw;
  }
}

Result<TemporaryFolder> TemporaryFolder::make(const fs::path& path) {
  TemporaryFolder folder(path);  // made before the folder, because this needs memory
  std::error_code failed;
  if (fs::create_directory(path, failed)) return folder;
  folder.keep();
  return io_error(path, "cannot make the folder", failed ? failed.value() : EEXIST);
}

// Errors are ignored: no code waits for them, and a destructor cannot report them.
TemporaryFolder::~TemporaryFolder() {
  if (!path_.empty() && process_ == ::getpid()) remove_tree(path_);
}

}  // namespace tessera
