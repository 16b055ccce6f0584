#include "src/export/output.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>

namespace tessera::exports {

namespace fs = std::filesystem;

Result<OutputFile> OutputFile::create(const fs::path& target) {
  store::TemporaryFile temporary(store::temporary_name(target));
  store::FileHandle file(::open(temporary.path().c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
  if (file.get() < 0) {
    const int number = errno;
    temporary.keep();  // not ours
    return store::io_error(target, "cannot create", number);
  }
  return OutputFile(target, std::move(temporary), std::move(file));
}

Result<std::uint64_t> OutputFile::finish() {
  struct stat status {};
  if (::fstat(file_.get(), &status) != 0) return store::io_error(target_, "cannot write", errno);
  if (!file_.close()) return store::io_error(target_, "cannot write", errno);
  BOOST_OUTCOME_TRYV(store::publish(temporary_.path(), target_));
  temporary_.keep();
  BOOST_OUTCOME_TRYV(store::sync_folder(target_.parent_path()));
  return static_cast<std::uint64_t>(status.st_size);
}

void Stream::write(std::size_t wanted) {
  if (status_) status_ = store::write_at(fd_, std::span(buffer_).first(used_), offset_, path_);
  offset_ += used_;
  used_ = 0;
  if (buffer_.size() < std::max(buffer_bytes, wanted)) buffer_.resize(std::max(buffer_bytes, wanted));
}

Status Stream::flush() {
  write();
  return status_;
}

std::string xml_text(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (c == '&') {
      result += "&amp;";
    } else if (c == '<') {
      result += "&lt;";
    } else if (c == '>') {
      result += "&gt;";
    } else if (c == '"') {
      result += "&quot;";
    } else {
      result += c;
    }
  }
  return result;
}

}  // namespace tessera::exports
