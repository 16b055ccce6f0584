#include "src/input/bytes/unpack.h"

#include <zlib.h>
#include <zstd.h>
#include <zstd_errors.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <utility>

namespace tessera {
namespace {

// Collects bytes until they fill a block.
class Blocks {
 public:
  explicit Blocks(const ByteSink& sink) : sink_(sink), block_(InputBuffer::block_bytes) {}

  std::span<std::byte> room() { return std::span(block_).subspan(used_); }
  Status add(std::size_t bytes) {
    used_ += bytes;
    if (used_ < block_.size()) return success();
    return flush();
  }
  Status flush() {
    const auto full = std::span<const std::byte>(block_).first(std::exchange(used_, 0));
    if (full.empty()) return success();
    return sink_(full);
  }

 private:
  const ByteSink& sink_;
  std::vector<std::byte> block_;
  std::size_t used_ = 0;
};

// The error messages that both formats share.
class Complaint {
 public:
  Complaint(FileFormat packing, const InputBuffer& in, const std::string& name)
      : packing_(packing), in_(in), name_(name) {}

  Error damaged(const std::string& how) const {
    return bad("is damaged: its " + stream() + " is wrong before byte " + std::to_string(in_.position()) + " (" + how +
               ")");
  }
  Error cut_off() const {
    return bad("is cut off: its " + stream() + " has no end after " + std::to_string(in_.position()) + " bytes");
  }
  Error followed() const {
    return bad("its " + stream() + " ends at byte " + std::to_string(in_.position()) +
               ", but the bytes after it are not such a stream; the file is damaged or not only " +
               packing_name(packing_));
  }
  Error too_large_a_window() const {
    return bad(
        "needs more than 128 MiB of memory to unpack; compress it at a level up to 19, and not in zstd's long mode");
  }
  Error no_memory() const { return error(Errc::memory, name_ + ": no memory is left to unpack it"); }

 private:
  std::string stream() const { return std::string(packing_name(packing_)) + " stream"; }
  Error bad(const std::string& what) const { return error(Errc::bad_input, name_ + ": " + what); }

  FileFormat packing_;
  const InputBuffer& in_;
  const std::string& name_;
};

struct Inflater {
  Inflater() {
    constexpr int window_bits_max = 15, with_gzip_header = 16;
    ready = inflateInit2(&stream, window_bits_max + with_gzip_header) == Z_OK;
  }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;
  ~Inflater() {
    if (ready) inflateEnd(&stream);
  }
  z_stream stream{};
  bool ready = false;
};

Status unpack_gzip(InputBuffer& in, const std::string& name, Blocks& out) {
  const Complaint complaint(FileFormat::gzip, in, name);
  Inflater inflater;
  if (!inflater.ready) return complaint.no_memory();
  auto& z = inflater.stream;
  while (true) {
    BOOST_OUTCOME_TRY(bytes, in.peek());
    if (bytes.empty()) return complaint.cut_off();
    const auto room = out.room();
    z.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(bytes.data()));
    z.avail_in = static_cast<uInt>(bytes.size());
    z.next_out = reinterpret_cast<Bytef*>(room.data());
    z.avail_out = static_cast<uInt>(room.size());
    const int code = inflate(&z, Z_NO_FLUSH);
    in.skip(bytes.size() - z.avail_in);
    if (code == Z_MEM_ERROR) return complaint.no_memory();
    // Z_BUF_ERROR means that there were too few bytes to go on. More bytes come, or the end.
    if (code != Z_OK && code != Z_STREAM_END && code != Z_BUF_ERROR)
      return complaint.damaged(z.msg != nullptr ? z.msg : "no reason given");
    BOOST_OUTCOME_TRYV(out.add(room.size() - z.avail_out));
    if (code != Z_STREAM_END) continue;
    BOOST_OUTCOME_TRY(next, in.peek(2));
    if (next.empty()) return success();
    if (format_of(next, "") != FileFormat::gzip) return complaint.followed();
    inflateReset(&z);
  }
}

Status unpack_zstd(InputBuffer& in, const std::string& name, Blocks& out) {
  const Complaint complaint(FileFormat::zstd, in, name);
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(), ZSTD_freeDCtx);
  if (!context) return complaint.no_memory();
  // Windows above 128 MiB stay refused, which is the library's default, so that memory is bounded.
  bool between_frames = true, more_to_come = false;
  while (true) {
    BOOST_OUTCOME_TRY(bytes, in.peek(4));  // the length of the magic number of a frame
    if (bytes.empty() && between_frames) return success();
    if (bytes.empty() && !more_to_come) return complaint.cut_off();
    if (between_frames && format_of(bytes, "") != FileFormat::zstd) return complaint.followed();
    const auto room = out.room();
    ZSTD_inBuffer from{bytes.data(), bytes.size(), 0};
    ZSTD_outBuffer to{room.data(), room.size(), 0};
    const std::size_t code = ZSTD_decompressStream(context.get(), &to, &from);
    in.skip(from.pos);
    if (ZSTD_getErrorCode(code) == ZSTD_error_frameParameter_windowTooLarge) return complaint.too_large_a_window();
    if (ZSTD_isError(code) != 0) return complaint.damaged(ZSTD_getErrorName(code));
    between_frames = code == 0;
    more_to_come = to.pos == to.size;
    BOOST_OUTCOME_TRYV(out.add(to.pos));
  }
}

Status copy(InputBuffer& in, Blocks& out) {
  while (true) {
    BOOST_OUTCOME_TRY(bytes, in.peek());
    if (bytes.empty()) return success();
    const std::size_t n = std::min(bytes.size(), out.room().size());
    std::memcpy(out.room().data(), bytes.data(), n);
    in.skip(n);
    BOOST_OUTCOME_TRYV(out.add(n));
  }
}

}  // namespace

InputBuffer::InputBuffer(Read read) : read_(std::move(read)), block_(block_bytes) {}

Result<std::span<const std::byte>> InputBuffer::peek(std::size_t least) {
  if (end_ - begin_ < least && !at_end_) {
    std::memmove(block_.data(), block_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
    while (end_ < least && !at_end_) {
      BOOST_OUTCOME_TRY(got, read_(std::span(block_).subspan(end_)));
      end_ += got;
      at_end_ = got == 0;
    }
  }
  return std::span<const std::byte>(block_).subspan(begin_, end_ - begin_);
}

void InputBuffer::skip(std::size_t bytes) {
  begin_ += bytes;
  position_ += bytes;
}

const char* packing_name(FileFormat format) {
  return format == FileFormat::gzip ? "gzip" : format == FileFormat::zstd ? "zstd" : "";
}

Status unpack(FileFormat packing, InputBuffer& in, const std::string& name, const ByteSink& sink) {
  Blocks out(sink);
  BOOST_OUTCOME_TRYV(packing == FileFormat::gzip   ? unpack_gzip(in, name, out)
                     : packing == FileFormat::zstd ? unpack_zstd(in, name, out)
                                                   : copy(in, out));
  return out.flush();
}

}  // namespace tessera
