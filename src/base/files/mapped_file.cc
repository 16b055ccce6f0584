#include "src/base/files/mapped_file.h"

#include <fcntl.h>
#include <sys/mman.h>

#include <cerrno>

namespace tessera {

Result<MappedFile> MappedFile::open(const std::filesystem::path& path) {
  BOOST_OUTCOME_TRY(file, open_handle(path, O_RDONLY));
  return open(file, path);
}

Result<MappedFile> MappedFile::open(const FileHandle& file, const std::filesystem::path& path) {
  BOOST_OUTCOME_TRY(size, size_of(file, path));
  if (size == 0) return MappedFile({});
  void* at = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file.get(), 0);
  if (at == MAP_FAILED) return io_error(path, "cannot map", errno);
  return MappedFile({static_cast<const std::byte*>(at), size});
}

MappedFile::~MappedFile() {
  if (!bytes_.empty()) ::munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
}

}  // namespace tessera
