#include "src/store/direct_writer.h"

#include <fcntl.h>

#include <xxhash.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>
#include <utility>

#include "src/base/stopped.h"

namespace tessera::store {
namespace {

constexpr std::size_t block_bytes = std::size_t{1} << 20;
constexpr std::size_t hashed_bytes = std::size_t{128} << 10;  // at a time, while they are in the second-level cache
constexpr std::size_t alignment = 4096;  // what disks and file systems ask for at most

}  // namespace

void DirectWriter::FreeState::operator()(XXH3_state_s* state) const { XXH3_freeState(state); }

DirectWriter::DirectWriter(FileHandle file, std::filesystem::path final_name, bool direct, std::stop_token stop)
    : file_(std::move(file)),
      final_name_(std::move(final_name)),
      direct_(direct),
      stop_(std::move(stop)),
      hash_(XXH3_createState()),
      block_(static_cast<std::byte*>(std::aligned_alloc(alignment, block_bytes))) {
  if (!block_ || !hash_) throw std::bad_alloc();
  XXH3_64bits_reset(hash_.get());
}

Result<DirectWriter> DirectWriter::create(const std::filesystem::path& path, const std::filesystem::path& final_name,
                                          std::stop_token stop) {
  bool direct = true;
  constexpr int flags = O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC;
  FileHandle file(::open(path.c_str(), flags | O_DIRECT, 0666));
  if (file.get() < 0 && errno == EINVAL) {  // tmpfs and some network file systems always go through the cache
    direct = false;
    file = FileHandle(::open(path.c_str(), flags, 0666));
  }
  if (file.get() < 0) return io_error(final_name, "cannot create", errno);
  return DirectWriter(std::move(file), final_name, direct, std::move(stop));
}

template <class Copy>
Status DirectWriter::append_by(std::span<const std::byte> bytes, const Copy& copy) {
  while (!bytes.empty()) {
    const std::size_t n = std::min(bytes.size(), block_bytes - filled_);
    copy(bytes.first(n), block_.get() + filled_);
    filled_ += n;
    bytes = bytes.subspan(n);
    if (filled_ - hashed_ >= hashed_bytes) hash_filled();
    if (filled_ == block_bytes) {
      BOOST_OUTCOME_TRYV(flush());
    }
  }
  return success();
}

Status DirectWriter::append(std::span<const std::byte> bytes) {
  return append_by(
      bytes, [](std::span<const std::byte> piece, std::byte* to) { std::memcpy(to, piece.data(), piece.size()); });
}

Status DirectWriter::append(std::span<const std::byte> bytes, BlockSum& sum) {
  return append_by(bytes, [&](std::span<const std::byte> piece, std::byte* to) { sum.copy(piece, to); });
}

Result<DirectWriter::Written> DirectWriter::finish() {
  // The last piece is no multiple of the alignment.
  if (filled_ % alignment != 0 && direct_ && !leave_direct()) return io_error(final_name_, "cannot write", errno);
  BOOST_OUTCOME_TRYV(flush());
  if (!file_.close()) return io_error(final_name_, "cannot write", errno);
  return Written{offset_, XXH3_64bits_digest(hash_.get())};
}

Status DirectWriter::flush() {
  throw_if_stopped(stop_);
  hash_filled();
  std::size_t done = 0;
  while (done < filled_) {
    const auto n = ::pwrite(file_.get(), block_.get() + done, filled_ - done, static_cast<off_t>(offset_ + done));
    if (n >= 0) {
      done += static_cast<std::size_t>(n);
      // A short write may end anywhere; a full disk shows in the next call.
      if (done % alignment != 0 && done < filled_ && direct_ && !leave_direct()) break;
    } else if (errno == EINVAL && direct_) {  // a disk with larger blocks
      if (!leave_direct()) break;
    } else if (errno != EINTR) {
      break;
    }
  }
  if (done < filled_) return io_error(final_name_, "cannot write", errno);
  offset_ += filled_;
  filled_ = hashed_ = 0;
  return success();
}

void DirectWriter::hash_filled() {
  XXH3_64bits_update(hash_.get(), block_.get() + hashed_, filled_ - hashed_);
  hashed_ = filled_;
}

bool DirectWriter::leave_direct() {
  direct_ = false;
  const int flags = ::fcntl(file_.get(), F_GETFL);
  return flags >= 0 && ::fcntl(file_.get(), F_SETFL, flags & ~O_DIRECT) == 0;
}

}  // namespace tessera::store
