#include "src/result/export/output.h"

#include <fcntl.h>

#include <algorithm>
#include <cerrno>

#include "src/base/files/names.h"
#include "src/base/files/whole_file.h"

namespace tessera::exports {

namespace fs = std::filesystem;

fs::path folder_of(const fs::path& target) { return target.has_parent_path() ? target.parent_path() : fs::path("."); }

Result<OutputFile> OutputFile::create(const fs::path& target) {
  TemporaryFile temporary(temporary_name(target));
  auto file = open_handle(temporary.path(), O_RDWR | O_CREAT | O_TRUNC, target);
  if (!file) {
    temporary.keep();  // not our file
    return file.error();
  }
  return OutputFile(target, std::move(temporary), std::move(file).value());
}

Result<std::uint64_t> OutputFile::finish() {
  BOOST_OUTCOME_TRY(size, size_of(file_, target_));
  if (!file_.close()) return io_error(target_, "cannot write", errno);
  BOOST_OUTCOME_TRYV(publish(temporary_.path(), target_));
  temporary_.keep();
  BOOST_OUTCOME_TRYV(sync_folder(target_.parent_path()));
  return size;
}

void Stream::write(std::size_t wanted) {
  if (status_) status_ = write_at(fd_, std::span(buffer_).first(used_), offset_, path_);
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
