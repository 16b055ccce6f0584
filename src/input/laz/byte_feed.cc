#include "src/input/laz/byte_feed.h"

#include <algorithm>

namespace tessera::laz {
namespace {

// A chunk of 50,000 points has some 200 kB in up to nine streams.
constexpr std::uint64_t piece_bytes = 64 << 10;
constexpr std::size_t zero_bytes = 256;

}  // namespace

void ByteFeed::refill() {
  const auto there = static_cast<std::size_t>(std::min(piece_bytes, end_ - next_));
  if (there > 0 && status_.has_value()) {
    piece_.resize(there);
    status_ = source_->read(next_, std::as_writable_bytes(std::span(piece_)));
    if (status_.has_value()) {
      next_ += there;
      at_ = piece_.data();
      stop_ = at_ + there;
      return;
    }
  }
  piece_.assign(zero_bytes, 0);
  at_ = piece_.data();
  stop_ = at_ + zero_bytes;
  zeros_ += zero_bytes;
}

}  // namespace tessera::laz
