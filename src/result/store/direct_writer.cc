#include "src/result/store/direct_writer.h"

#include <fcntl.h>

#include <xxhash.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>
#include <utility>

#include "src/base/ledger.h"
#include "src/base/stopped.h"

namespace tessera::store {
namespace {

constexpr std::size_t hashed_bytes = std::size_t{128} << 10;  // at a time, while in the second-level cache
constexpr std::size_t alignment = 4096;                       // the most that disks and file systems ask for

constexpr std::uint64_t whole_pieces(std::uint64_t bytes) { return bytes / sum_piece_bytes * sum_piece_bytes; }

}  // namespace

void DirectWriter::FreeState::operator()(XXH3_state_s* state) const { XXH3_freeState(state); }

DirectWriter::DirectWriter(FileHandle file, std::filesystem::path final_name, bool direct, std::stop_token stop)
    : file_(std::move(file)),
      final_name_(std::move(final_name)),
      direct_(direct),
      stop_(std::move(stop)),
      hash_(XXH3_createState()),
      piece_(static_cast<std::byte*>(std::aligned_alloc(alignment, sum_piece_bytes))) {
  if (!piece_ || !hash_) throw std::bad_alloc();
  XXH3_64bits_reset(hash_.get());
}

Result<DirectWriter> DirectWriter::open(const std::filesystem::path& path, const std::filesystem::path& final_name,
                                        int flags, const char* what, std::stop_token stop) {
  bool direct = true;
  flags |= O_CLOEXEC | O_NONBLOCK;  // O_NONBLOCK: opening a pipe must not wait for a reader
  FileHandle file(::open(path.c_str(), flags | O_DIRECT, 0666));
  if (file.get() < 0 && errno == EINVAL) {  // tmpfs and some network file systems always use the cache
    direct = false;
    file = FileHandle(::open(path.c_str(), flags, 0666));
  }
  if (file.get() < 0) return io_error(final_name, what, errno);
  return DirectWriter(std::move(file), final_name, direct, std::move(stop));
}

Result<DirectWriter> DirectWriter::create(const std::filesystem::path& path, const std::filesystem::path& final_name,
                                          std::stop_token stop) {
  return open(path, final_name, O_WRONLY | O_CREAT | O_TRUNC, "cannot create", std::move(stop));
}

Result<DirectWriter> DirectWriter::go_on(const std::filesystem::path& path, const std::filesystem::path& final_name,
                                         Begun begun, std::stop_token stop) {
  BOOST_OUTCOME_TRY(writer, open(path, final_name, O_RDWR, "cannot be opened to write the rest", std::move(stop)));
  writer.begun_ = std::move(begun);
  BOOST_OUTCOME_TRYV(writer.begin_piece(0));
  return std::move(writer);
}

template <class Copy>
Status DirectWriter::append_by(std::span<const std::byte> bytes, const Copy& copy) {
  while (!bytes.empty()) {
    const std::size_t n = std::min(bytes.size(), sum_piece_bytes - filled_);
    copy(bytes.first(n), piece_.get() + filled_);
    filled_ += n;
    bytes = bytes.subspan(n);
    if (filled_ - hashed_ >= hashed_bytes) hash_filled();
    if (filled_ == sum_piece_bytes) {
      BOOST_OUTCOME_TRYV(write_piece());
      BOOST_OUTCOME_TRYV(begin_piece(offset_ + sum_piece_bytes));
    }
  }
  return success();
}

Status DirectWriter::append(std::span<const std::byte> bytes) {
  return append_by(
      bytes, [](std::span<const std::byte> piece, std::byte* to) { std::memcpy(to, piece.data(), piece.size()); });
}

Status DirectWriter::append(std::span<const std::byte> bytes, BlockChecksum& sum) {
  return append_by(bytes, [&](std::span<const std::byte> piece, std::byte* to) { sum.copy(piece, to); });
}

Status DirectWriter::skip_to(std::uint64_t offset) {
  // The offset of early cells comes from a scratch file, so it may be wrong.
  if (offset < offset_ + filled_)
    return error(Errc::corrupt, final_name_.string() + ": the parts that were written of it overlap");
  if (const std::uint64_t piece = whole_pieces(offset); piece != offset_) {
    if (filled_ > 0) {
      fill_up_to(sum_piece_bytes);
      BOOST_OUTCOME_TRYV(write_piece());
    }
    BOOST_OUTCOME_TRYV(begin_piece(piece));
  }
  fill_up_to(offset - offset_);
  return success();
}

Result<DirectWriter::Begun> DirectWriter::pause() {
  if (filled_ > 0) {
    fill_up_to((filled_ + alignment - 1) / alignment * alignment);
    BOOST_OUTCOME_TRYV(write_piece());
  }
  begun_.bytes = offset_ + filled_;
  BOOST_OUTCOME_TRYV(close());
  return std::move(begun_);
}

Result<DirectWriter::Written> DirectWriter::finish() {
  if (known_ > filled_)
    return error(Errc::corrupt, final_name_.string() + ": the part that was written of it is too long");
  // The last piece is not a multiple of the alignment.
  if (filled_ % alignment != 0 && direct_ && !leave_direct()) return io_error(final_name_, "cannot write", errno);
  if (filled_ > 0) {
    BOOST_OUTCOME_TRYV(write_piece());
  }
  BOOST_OUTCOME_TRYV(close());
  return Written{offset_ + filled_, checksum(std::as_bytes(std::span(begun_.sums)))};
}

Status DirectWriter::close() {
  return file_.close() ? Status(success()) : Status(io_error(final_name_, "cannot write", errno));
}

// Reads what the file has of the piece already, because pieces are written as a whole.
Status DirectWriter::begin_piece(std::uint64_t offset) {
  offset_ = offset;
  filled_ = hashed_ = known_ = 0;
  XXH3_64bits_reset(hash_.get());
  if (offset >= begun_.bytes) return success();
  const auto there = std::min<std::uint64_t>(begun_.bytes - offset, sum_piece_bytes);
  const std::span<std::byte> piece(piece_.get(), sum_piece_bytes);
  auto read = read_up_to(file_.get(), piece, offset, final_name_);
  if (!read && direct_ && leave_direct()) read = read_up_to(file_.get(), piece, offset, final_name_);
  if (!read) return read.error();
  if (read.value() < there)
    return error(Errc::corrupt, final_name_.string() + ": the part that was written of it is cut off");
  known_ = there;
  return success();
}

// Writes the piece, followed by the bytes that the file had there before.
Status DirectWriter::write_piece() {
  throw_if_stopped(stop_);
  fill_up_to(std::max(filled_, known_));
  hash_filled();
  BOOST_OUTCOME_TRYV(Ledger::draw_write(filled_));
  std::size_t done = 0;
  while (done < filled_) {
    const auto n = ::pwrite(file_.get(), piece_.get() + done, filled_ - done, static_cast<off_t>(offset_ + done));
    if (n >= 0) {
      done += static_cast<std::size_t>(n);
      // A short write may end anywhere. If the disk is full, the next call says so.
      if (done % alignment != 0 && done < filled_ && direct_ && !leave_direct()) break;
    } else if (errno == EINVAL && direct_) {  // a disk with larger blocks
      if (!leave_direct()) break;
    } else if (errno != EINTR) {
      break;
    }
  }
  if (done < filled_) return io_error(final_name_, "cannot write", errno);
  static const std::uint64_t zeros = checksum(std::vector<std::byte>(sum_piece_bytes));
  const std::size_t number = offset_ / sum_piece_bytes;
  if (begun_.sums.size() <= number) begun_.sums.resize(number + 1, zeros);  // pieces that were passed over
  begun_.sums[number] = XXH3_64bits_digest(hash_.get());
  return success();
}

void DirectWriter::hash_filled() {
  XXH3_64bits_update(hash_.get(), piece_.get() + hashed_, filled_ - hashed_);
  hashed_ = filled_;
}

// Fills with the bytes that the file had before, then with zeros.
void DirectWriter::fill_up_to(std::size_t end) {
  if (const std::size_t from = std::max(filled_, known_); from < end) std::memset(piece_.get() + from, 0, end - from);
  filled_ = std::max(filled_, end);
}

bool DirectWriter::leave_direct() {
  direct_ = false;
  const int flags = ::fcntl(file_.get(), F_GETFL);
  return flags >= 0 && ::fcntl(file_.get(), F_SETFL, flags & ~O_DIRECT) == 0;
}

}  // namespace tessera::store
