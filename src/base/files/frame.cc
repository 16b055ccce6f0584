#include "src/base/files/frame.h"

#include <fcntl.h>
#include <sys/uio.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

#include "src/base/files/checksum.h"
#include "src/base/files/descriptor.h"
#include "src/base/files/temporary.h"
#include "src/base/files/whole_file.h"

namespace tessera {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little, "frames are little endian and written without conversion");

namespace {

constexpr std::uint32_t magic = 0x62467354;        // "TsFb"
constexpr std::uint32_t older_magic = 0x72467354;  // "TsFr": a shorter header without the owner

struct Header {
  std::uint32_t magic = 0;
  std::uint32_t kind = 0;
  std::uint64_t length = 0;
  FrameOwner owner;
  std::uint64_t checksum = 0;
};
static_assert(sizeof(Header) == frame_header_bytes);

std::uint64_t checksum_of(const Header& header, std::span<const std::byte> payload) {
  const auto fields = std::as_bytes(std::span(&header, 1)).first(sizeof header - sizeof header.checksum);
  return checksum(payload, checksum(fields));
}

// Writes header and payload in one call when the system takes them, so that an append of another process cannot come
// between.
Status write_framed(int fd, ScratchKind kind, const FrameOwner& owner, std::span<const std::byte> payload,
                    const fs::path& path) {
  Header header{magic, static_cast<std::uint32_t>(kind), payload.size(), owner, 0};
  header.checksum = checksum_of(header, payload);
  std::array<iovec, 2> parts{{{&header, sizeof header}, {const_cast<std::byte*>(payload.data()), payload.size()}}};
  ssize_t n = 0;
  do {
    n = ::writev(fd, parts.data(), static_cast<int>(parts.size()));
  } while (n < 0 && errno == EINTR);
  if (n < 0) return io_error(path, "cannot write", errno);
  auto done = static_cast<std::size_t>(n);
  if (done < sizeof header) {
    BOOST_OUTCOME_TRYV(write_on(fd, std::as_bytes(std::span(&header, 1)).subspan(done), path));
    done = sizeof header;
  }
  return write_on(fd, payload.subspan(done - sizeof header), path);
}

Status write_new(const fs::path& path, int flags, ScratchKind kind, const FrameOwner& owner,
                 std::span<const std::byte> payload, const fs::path& final_name) {
  BOOST_OUTCOME_TRY(file, open_handle(path, O_WRONLY | O_CREAT | flags, final_name));
  BOOST_OUTCOME_TRYV(write_framed(file.get(), kind, owner, payload, final_name));
  if (!file.close()) return io_error(final_name, "cannot write", errno);
  return success();
}

// Reads the frames of an open file in order.
class FrameReader {
 public:
  static Result<FrameReader> open(const fs::path& path, ScratchKind kind) {
    BOOST_OUTCOME_TRY(file, open_handle(path, O_RDONLY));
    BOOST_OUTCOME_TRY(size, size_of(file, path));
    return FrameReader(path, kind, std::move(file), size);
  }

  bool at_end() const { return at_ == size_; }
  // A place beyond the end of the file counts as the end.
  void go_to(std::uint64_t at) { at_ = begin_ = std::min(at, size_); }

  // REQUIRES: !at_end().
  Result<BigVector<std::byte>> next(const FrameOwner& owner) {
    BOOST_OUTCOME_TRY(header, next_header());
    BigVector<std::byte> payload(header.length);
    BOOST_OUTCOME_TRYV(read(payload));
    if (header.checksum != checksum_of(header, payload))
      return damaged("the frame is damaged: its checksum is not the one that was written");
    if (header.owner.run != owner.run) return damaged("the frame belongs to another run");
    if (header.owner.item != owner.item)
      return damaged("the frame belongs to number " + std::to_string(header.owner.item) +
                     " of the run, not to number " + std::to_string(owner.item));
    begin_ = at_;
    return payload;
  }

  // The owner and place of the next frame, whose payload is skipped.
  Result<FrameOffset> next_offset() {
    const std::uint64_t at = at_;
    BOOST_OUTCOME_TRY(header, next_header());
    at_ = begin_ = at_ + header.length;
    return FrameOffset{header.owner, at};
  }

  Error damaged(const std::string& what) const {
    return error(Errc::corrupt, path_.string() + ", byte " + std::to_string(begin_) + ": " + what);
  }

 private:
  FrameReader(fs::path path, ScratchKind kind, FileHandle file, std::uint64_t size)
      : path_(std::move(path)), kind_(kind), file_(std::move(file)), size_(size) {}

  Result<Header> next_header() {
    Header header;
    const std::uint64_t left = std::min<std::uint64_t>(size_ - at_, sizeof header);
    BOOST_OUTCOME_TRYV(read(std::as_writable_bytes(std::span(&header, 1)).first(left)));
    if (left >= sizeof header.magic && header.magic == older_magic)
      return damaged("the frame has the format of an older version of Tessera");
    if (left < sizeof header) return damaged("the file ends in the middle of a frame");
    if (header.magic != magic) return damaged("no frame begins here");
    if (header.kind != static_cast<std::uint32_t>(kind_)) return damaged("the frame is of another kind than expected");
    if (header.length > size_ - at_) return damaged("the file ends in the middle of a frame");
    return header;
  }

  Status read(std::span<std::byte> buffer) {
    BOOST_OUTCOME_TRY(done, read_up_to(file_.get(), buffer, at_, path_));
    if (done != buffer.size()) return damaged("the file became shorter while it was read");
    at_ += done;
    return success();
  }

  fs::path path_;
  ScratchKind kind_;
  FileHandle file_;
  std::uint64_t size_;
  std::uint64_t at_ = 0;
  std::uint64_t begin_ = 0;  // where the frame begins that is being read
};

}  // namespace

Status append_frame(const fs::path& path, ScratchKind kind, const FrameOwner& owner,
                    std::span<const std::byte> payload) {
  return write_new(path, O_APPEND, kind, owner, payload, path);
}

Status write_frame(const fs::path& path, ScratchKind kind, const FrameOwner& owner,
                   std::span<const std::byte> payload) {
  TemporaryFile temporary(temporary_name_of_process(path));
  BOOST_OUTCOME_TRYV(write_new(temporary.path(), O_TRUNC, kind, owner, payload, path));
  BOOST_OUTCOME_TRYV(rename_file(temporary.path(), path));
  temporary.keep();
  return success();
}

Result<BigVector<std::byte>> read_frame(const fs::path& path, ScratchKind kind, const FrameOwner& owner) {
  BOOST_OUTCOME_TRY(frames, FrameReader::open(path, kind));
  if (frames.at_end()) return frames.damaged("the file is empty");
  BOOST_OUTCOME_TRY(payload, frames.next(owner));
  if (!frames.at_end()) return frames.damaged("the file has more bytes after its only frame");
  return std::move(payload);
}

Status for_each_frame(const fs::path& path, ScratchKind kind, const FrameOwner& owner, const VisitFrame& visit) {
  BOOST_OUTCOME_TRY(frames, FrameReader::open(path, kind));
  while (!frames.at_end()) {
    BOOST_OUTCOME_TRY(payload, frames.next(owner));
    BOOST_OUTCOME_TRYV(visit(std::move(payload)));
  }
  return success();
}

Result<std::vector<FrameOffset>> frame_offsets(const fs::path& path, ScratchKind kind) {
  BOOST_OUTCOME_TRY(frames, FrameReader::open(path, kind));
  std::vector<FrameOffset> offsets;
  while (!frames.at_end()) {
    const auto offset = frames.next_offset();
    if (!offset && offset.error().code == Errc::corrupt) break;
    if (!offset) return offset.error();
    offsets.push_back(offset.value());
  }
  return offsets;
}

Result<BigVector<std::byte>> read_frame_at(const fs::path& path, ScratchKind kind, const FrameOwner& owner,
                                           std::uint64_t at) {
  BOOST_OUTCOME_TRY(frames, FrameReader::open(path, kind));
  frames.go_to(at);
  return frames.next(owner);
}

}  // namespace tessera
