#include "src/base/files/disk_file.h"

#include <fcntl.h>

#include <cerrno>

namespace tessera {

Result<DiskFile> DiskFile::open(const std::filesystem::path& path, Mode mode) {
  const int flags = mode == Mode::read     ? O_RDONLY
                    : mode == Mode::append ? O_WRONLY | O_CREAT | O_APPEND
                                           : O_WRONLY | O_CREAT | O_TRUNC;
  BOOST_OUTCOME_TRY(file, open_handle(path, flags));
  return DiskFile(path, std::move(file));
}

Result<std::size_t> DiskFile::read(std::span<std::byte> buffer) {
  BOOST_OUTCOME_TRY(done, read_up_to(file_.get(), buffer, read_, path_));
  read_ += done;
  return done;
}

Status DiskFile::close() {
  if (!file_.close()) return io_error(path_, "cannot write", errno);
  return success();
}

}  // namespace tessera
