#include "src/result/store/data_file.h"

#include <fcntl.h>

#include <algorithm>
#include <utility>

namespace tessera {

Result<DataFile> DataFile::open(const std::filesystem::path& path) {
  BOOST_OUTCOME_TRY(file, open_handle(path, O_RDONLY));
  BOOST_OUTCOME_TRY(bytes, size_of(file, path));
  return DataFile(path, bytes, std::move(file));
}

DataFile::DataFile(std::filesystem::path name, std::uint64_t bytes, Read read)
    : path_(std::move(name)), bytes_(bytes), read_(std::move(read)) {}

DataFile::DataFile(std::filesystem::path path, std::uint64_t bytes, FileHandle file)
    : path_(std::move(path)), bytes_(bytes), file_(std::move(file)) {}

Result<std::size_t> DataFile::read_up_to(std::uint64_t offset, std::span<std::byte> out) const {
  if (!read_) return tessera::read_up_to(file_.get(), out, offset, path_);
  const auto here = offset < bytes_ ? std::min<std::uint64_t>(out.size(), bytes_ - offset) : 0;
  if (here == 0) return std::size_t{0};
  BOOST_OUTCOME_TRYV(read_(offset, out.first(static_cast<std::size_t>(here))));
  return static_cast<std::size_t>(here);
}

}  // namespace tessera
