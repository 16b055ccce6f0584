#include "src/input/bytes/byte_source.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "src/input/bytes/far_source.h"

namespace tessera {
namespace {

std::string reason(int code) { return std::generic_category().message(code); }

std::int64_t nanoseconds(const timespec& t) { return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec; }

class FileSource : public ByteSource {
 public:
  FileSource(std::filesystem::path path, std::filesystem::path content_name, int file, const struct stat& status)
      : path_(std::move(path)),
        content_name_(std::move(content_name)),
        file_(file),
        size_(static_cast<std::uint64_t>(status.st_size)),
        modified_ns_(nanoseconds(status.st_mtim)) {}
  FileSource(const FileSource&) = delete;
  FileSource& operator=(const FileSource&) = delete;
  ~FileSource() override { ::close(file_); }

  const std::filesystem::path& path() const override { return path_; }
  std::uint64_t size() const override { return size_; }
  std::int64_t modified_ns() const override { return modified_ns_; }

  std::filesystem::path content_name() const override { return content_name_; }

  Status read(std::uint64_t offset, std::span<std::byte> out) const override {
    return read_at(file_, offset, out, path_);
  }

  Status check_unchanged() const override {
    struct stat now {};
    if (::fstat(file_, &now) != 0) return error(Errc::io, path_.string() + ": cannot be examined: " + reason(errno));
    if (static_cast<std::uint64_t>(now.st_size) != size_ || nanoseconds(now.st_mtim) != modified_ns_)
      return error(Errc::bad_input, path_.string() + ": was changed by another program while it was read");
    return success();
  }

 private:
  std::filesystem::path path_, content_name_;
  int file_;
  std::uint64_t size_;
  std::int64_t modified_ns_;
};

// `Kind`: ByteSource or FarSource.
template <class Kind>
class SharedSource : public Kind {
 public:
  explicit SharedSource(std::shared_ptr<const Kind> source) : source_(std::move(source)) {}
  const std::filesystem::path& path() const override { return source_->path(); }
  std::uint64_t size() const override { return source_->size(); }
  std::int64_t modified_ns() const override { return source_->modified_ns(); }
  std::uint64_t stored_bytes() const override { return source_->stored_bytes(); }
  std::string packing() const override { return source_->packing(); }
  std::filesystem::path content_name() const override { return source_->content_name(); }
  Status read(std::uint64_t offset, std::span<std::byte> out) const override { return source_->read(offset, out); }
  Status check_unchanged() const override { return source_->check_unchanged(); }

 protected:
  const Kind& shared() const { return *source_; }

 private:
  std::shared_ptr<const Kind> source_;
};

class SharedFarSource : public SharedSource<FarSource> {
 public:
  using SharedSource::SharedSource;
  Status bring(std::span<const ByteRange> ranges) const override { return shared().bring(ranges); }
  std::uint64_t near_bytes_max() const override { return shared().near_bytes_max(); }
  Result<std::shared_ptr<const ByteSource>> open_beside(const std::string& name,
                                                        std::size_t first_bytes) const override {
    return shared().open_beside(name, first_bytes);
  }
  std::shared_ptr<const Learnt> learnt() const override { return shared().learnt(); }
  void learn(std::shared_ptr<const Learnt> what) const override { shared().learn(std::move(what)); }
};

class MemorySource : public ByteSource {
 public:
  MemorySource(std::filesystem::path name, std::vector<std::byte> bytes)
      : path_(std::move(name)), bytes_(std::move(bytes)) {}
  const std::filesystem::path& path() const override { return path_; }
  std::uint64_t size() const override { return bytes_.size(); }
  std::int64_t modified_ns() const override { return 0; }
  Status read(std::uint64_t offset, std::span<std::byte> out) const override {
    if (offset > bytes_.size() || out.size() > bytes_.size() - offset)
      return error(Errc::bad_input, path_.string() + ": became shorter while it was read");
    if (!out.empty()) std::memcpy(out.data(), bytes_.data() + offset, out.size());
    return success();
  }
  Status check_unchanged() const override { return success(); }

 private:
  std::filesystem::path path_;
  std::vector<std::byte> bytes_;
};

}  // namespace

Result<std::unique_ptr<ByteSource>> open_file(const std::filesystem::path& path) {
  // O_NONBLOCK: otherwise opening a named pipe without a writer would hang. It does not affect regular files.
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) return error(Errc::io, path.string() + ": cannot be opened: " + reason(errno));
  return open_descriptor(path, file, path);
}

Result<std::unique_ptr<ByteSource>> open_descriptor(const std::filesystem::path& path, int file,
                                                    const std::filesystem::path& content_name) {
  struct stat status {};
  if (::fstat(file, &status) != 0) {
    const int code = errno;
    ::close(file);
    return error(Errc::io, path.string() + ": cannot be examined: " + reason(code));
  }
  if (!S_ISREG(status.st_mode)) {
    ::close(file);
    return error(
        Errc::bad_input,
        path.string() + (S_ISDIR(status.st_mode)
                             ? ": is a folder"
                             : ": is not a regular file; of pipes and devices, only standard input is read, as '-'"));
  }
  ::posix_fadvise(file, 0, 0, POSIX_FADV_SEQUENTIAL);
  return std::unique_ptr<ByteSource>(new FileSource(path, content_name, file, status));
}

Status read_at(int file, std::uint64_t offset, std::span<std::byte> out, const std::filesystem::path& path) {
  while (!out.empty()) {
    const auto got = ::pread(file, out.data(), out.size(), static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return error(Errc::io, path.string() + ": cannot be read: " + reason(errno));
    if (got == 0) return error(Errc::bad_input, path.string() + ": became shorter while it was read");
    offset += static_cast<std::uint64_t>(got);
    out = out.subspan(static_cast<std::size_t>(got));
  }
  return success();
}

std::unique_ptr<ByteSource> share(std::shared_ptr<const ByteSource> source) {
  if (auto far = std::dynamic_pointer_cast<const FarSource>(source))
    return std::make_unique<SharedFarSource>(std::move(far));
  return std::make_unique<SharedSource<ByteSource>>(std::move(source));
}

std::unique_ptr<ByteSource> memory_source(std::filesystem::path name, std::vector<std::byte> bytes) {
  return std::make_unique<MemorySource>(std::move(name), std::move(bytes));
}

}  // namespace tessera
