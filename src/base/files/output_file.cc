#include "src/base/files/output_file.h"

#include <fcntl.h>

#include <cerrno>
#include <system_error>

#include "src/base/files/names.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"

namespace tessera {
namespace {

constexpr const char* refused = "cannot be written";
constexpr std::size_t buffer_bytes = std::size_t{1} << 20;

}  // namespace

OutputFile::OutputFile(std::filesystem::path path, TemporaryFile temporary, FileHandle file)
    : path_(std::move(path)), temporary_(std::move(temporary)), file_(std::move(file)) {
  buffer_.reserve(buffer_bytes);
}

Result<OutputFile> OutputFile::create(const std::filesystem::path& path) {
  BOOST_OUTCOME_TRY(folder, is_folder(path));
  if (folder) return error(Errc::io, path.string() + ": cannot be written: it is a directory");
  TemporaryFile temporary(temporary_name_of_process(path));
  FileHandle file(::open(temporary.path().c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
  if (file.get() < 0) {
    const int number = errno;
    temporary.keep();  // the file is not this process's
    return io_error(path, refused, number);
  }
  return OutputFile(path, std::move(temporary), std::move(file));
}

Status OutputFile::append(std::span<const std::byte> bytes) {
  if (buffer_.size() + bytes.size() > buffer_bytes) {
    BOOST_OUTCOME_TRYV(flush());
  }
  if (bytes.size() >= buffer_bytes) {
    BOOST_OUTCOME_TRYV(write_at(file_.get(), bytes, flushed_, path_, refused));
    flushed_ += bytes.size();
    return success();
  }
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  return success();
}

Status OutputFile::overwrite(std::uint64_t offset, std::span<const std::byte> bytes) {
  BOOST_OUTCOME_TRYV(flush());
  return write_at(file_.get(), bytes, offset, path_, refused);
}

Status OutputFile::commit() {
  BOOST_OUTCOME_TRYV(flush());
  if (!file_.close()) return io_error(path_, refused, errno);
  BOOST_OUTCOME_TRYV(publish(temporary_.path(), path_));
  temporary_.keep();
  return success();
}

Status OutputFile::flush() {
  BOOST_OUTCOME_TRYV(write_at(file_.get(), buffer_, flushed_, path_, refused));
  flushed_ += buffer_.size();
  buffer_.clear();
  return success();
}

}  // namespace tessera
