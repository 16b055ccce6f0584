#include "src/input/bytes/spool.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <string>
#include <utility>

#include "src/base/files/descriptor.h"
#include "src/base/files/temporary.h"
#include "src/base/ledger.h"
#include "src/input/format.h"

namespace tessera {
namespace {

constexpr const char* standard_input_name = "standard input";

std::string megabytes(std::uint64_t bytes) {
  return std::to_string(bytes / 1'000'000) + "." + std::to_string(bytes / 100'000 % 10) + " MB";
}

// Reads from standard input as soon as there are bytes.
Result<std::size_t> read_standard_input(std::span<std::byte> out, const std::stop_token& stop) {
  while (true) {
    if (stop.stop_requested()) return error(Errc::interrupted, "interrupted while standard input was read");
    pollfd wanted{STDIN_FILENO, POLLIN, 0};
    constexpr int tenth_of_a_second_ms = 100;
    const int ready = ::poll(&wanted, 1, tenth_of_a_second_ms);
    if (ready == 0 || (ready < 0 && errno == EINTR)) continue;
    const auto got = ::read(STDIN_FILENO, out.data(), out.size());
    if (got >= 0) return static_cast<std::size_t>(got);
    if (errno != EINTR && errno != EAGAIN)
      return error(Errc::io,
                   std::string(standard_input_name) + ": cannot be read: " + std::generic_category().message(errno));
  }
}

}  // namespace

struct Spool::File {
  explicit File(FileHandle opened) : handle(std::move(opened)) {}
  FileHandle handle;
  std::uint64_t size = 0;
};

// What a kept source says about its origin.
struct Spool::Origin {
  std::filesystem::path path, content_name;
  std::int64_t modified_ns = 0;
  std::string packing = {};
};

class Spool::Source : public ByteSource {
 public:
  struct Extent {
    std::uint64_t begin, size, stored_bytes;
  };
  Source(std::shared_ptr<File> file, Origin origin, Extent extent)
      : file_(std::move(file)), origin_(std::move(origin)), extent_(extent) {}

  const std::filesystem::path& path() const override { return origin_.path; }
  std::uint64_t size() const override { return extent_.size; }
  std::int64_t modified_ns() const override { return origin_.modified_ns; }
  std::uint64_t stored_bytes() const override { return extent_.stored_bytes; }
  std::string packing() const override { return origin_.packing; }
  std::filesystem::path content_name() const override { return origin_.content_name; }

  Status read(std::uint64_t offset, std::span<std::byte> out) const override {
    return read_at(file_->handle.get(), extent_.begin + offset, out, origin_.path);
  }
  Status check_unchanged() const override { return success(); }  // no other process can reach the file

 private:
  std::shared_ptr<File> file_;
  Origin origin_;
  Extent extent_;
};

Spool::Spool(std::filesystem::path folder, std::stop_token stop, std::uint64_t bytes_max)
    : folder_(std::move(folder)), stop_(std::move(stop)), bytes_max_(bytes_max) {}

Result<std::shared_ptr<Spool::File>> Spool::take() {
  {
    const std::lock_guard lock(mutex_);
    if (!idle_.empty()) {
      auto file = std::move(idle_.back());
      idle_.pop_back();
      return file;
    }
  }
  BOOST_OUTCOME_TRY(folder, folder_for_temporary(folder_));
  BOOST_OUTCOME_TRY(file, nameless_file(folder));
  return std::make_shared<File>(std::move(file));
}

Result<std::shared_ptr<const ByteSource>> Spool::keep(Origin origin, FileFormat packing, InputBuffer& in) {
  BOOST_OUTCOME_TRY(file, take());
  const std::string name = origin.path.string();
  const std::uint64_t begin = file->size;
  const auto write = [&](std::span<const std::byte> block) -> Status {
    if (stop_.stop_requested()) return error(Errc::interrupted, "interrupted while " + name + " was unpacked");
    // Content that no reader can read need not be unpacked.
    if (file->size == begin &&
        format_of(block.first(std::min(block.size(), format_bytes)), origin.content_name) == FileFormat::unknown)
      return unknown_format(origin.path);
    if ((bytes_ += block.size()) > bytes_max_ && bytes_max_ > 0) {
      return error(Errc::memory, name +
                                     ": is too large to unpack here: with the files unpacked before it, it exceeds " +
                                     megabytes(bytes_max_));
    }
    BOOST_OUTCOME_TRYV(Ledger::draw_write(block.size()));
    while (!block.empty()) {
      const auto put = ::pwrite(file->handle.get(), block.data(), block.size(), static_cast<off_t>(file->size));
      if (put < 0 && errno == EINTR) continue;
      if (put < 0) {
        const std::string why = std::generic_category().message(errno);
        const std::string where = folder_.empty() ? "the system's temporary folder (see TMPDIR)" : folder_.string();
        return error(Errc::io, name + ": could not be kept in " + where + " beyond its first " +
                                   megabytes(file->size - begin) + ": " + why);
      }
      file->size += static_cast<std::uint64_t>(put);
      block = block.subspan(static_cast<std::size_t>(put));
    }
    return success();
  };
  BOOST_OUTCOME_TRYV(unpack(packing, in, name, write));
  origin.packing = packing_name(packing);
  auto source =
      std::make_shared<const Source>(file, std::move(origin), Source::Extent{begin, file->size - begin, in.position()});
  const std::lock_guard lock(mutex_);
  idle_.push_back(std::move(file));
  return std::shared_ptr<const ByteSource>(std::move(source));
}

Result<std::shared_ptr<const ByteSource>> Spool::unpacked(std::shared_ptr<const ByteSource> source) {
  std::array<std::byte, format_bytes> begin{};
  const auto there =
      std::span(begin).first(static_cast<std::size_t>(std::min<std::uint64_t>(begin.size(), source->size())));
  BOOST_OUTCOME_TRYV(source->read(0, there));
  const auto packing = format_of(there, source->content_name());
  if (packing != FileFormat::gzip && packing != FileFormat::zstd) return source;
  std::uint64_t at = 0;
  InputBuffer in([&](std::span<std::byte> out) -> Result<std::size_t> {
    const auto n = static_cast<std::size_t>(std::min<std::uint64_t>(out.size(), source->size() - at));
    BOOST_OUTCOME_TRYV(source->read(at, out.first(n)));
    at += n;
    return n;
  });
  BOOST_OUTCOME_TRY(kept, keep({.path = source->path(),
                                .content_name = without_packing(source->content_name()),
                                .modified_ns = source->modified_ns()},
                               packing, in));
  BOOST_OUTCOME_TRYV(source->check_unchanged());
  return std::move(kept);
}

Result<std::shared_ptr<const ByteSource>> Spool::standard_input() {
  const std::string name = standard_input_name;
  if (::isatty(STDIN_FILENO) != 0)
    return error(Errc::usage, name + ": is a terminal; pipe points into it, or name a file instead of '-'");
  struct stat status {};
  if (::fstat(STDIN_FILENO, &status) != 0)
    return error(Errc::io, name + ": cannot be examined: " + std::generic_category().message(errno));
  if (S_ISDIR(status.st_mode)) return error(Errc::bad_input, name + ": is a folder");
  if (S_ISREG(status.st_mode) && ::lseek(STDIN_FILENO, 0, SEEK_CUR) == 0) {
    BOOST_OUTCOME_TRY(file, open_descriptor(name, ::fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 0), ""));
    return unpacked(std::move(file));
  }
  InputBuffer in([&](std::span<std::byte> out) { return read_standard_input(out, stop_); });
  BOOST_OUTCOME_TRY(begin, in.peek(format_bytes));
  if (begin.empty()) return error(Errc::bad_input, name + ": is empty");
  const auto packing = format_of(begin.first(std::min(begin.size(), format_bytes)), "");
  return keep({.path = name, .content_name = {}}, packing, in);
}

}  // namespace tessera
