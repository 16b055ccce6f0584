#include "src/input/pcd/lzf_stream.h"

#include <algorithm>
#include <string>

namespace tessera {

Error LzfStream::damaged(const char* what) const {
  return error(Errc::bad_input, source_->path().string() + ": the compressed points are damaged: " + what + " after " +
                                    std::to_string(given_) + " bytes");
}

Result<std::byte> LzfStream::take() {
  if (block_begin_ == block_.size()) {
    if (at_ == end_) return damaged("they end");
    block_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(std::uint64_t{1} << 16, end_ - at_)));
    BOOST_OUTCOME_TRYV(source_->read(at_, block_));
    at_ += block_.size();
    block_begin_ = 0;
  }
  return block_[block_begin_++];
}

Status LzfStream::next_instruction() {
  BOOST_OUTCOME_TRY(first, take());
  const auto control = static_cast<unsigned>(first);
  if (control < 32) {
    left_ = control + 1;
    distance_ = 0;
    return success();
  }
  std::size_t length = control >> 5;
  if (length == 7) {
    BOOST_OUTCOME_TRY(more, take());
    length += static_cast<std::size_t>(more);
  }
  BOOST_OUTCOME_TRY(low, take());
  left_ = length + 2;
  distance_ = ((control & 31U) << 8 | static_cast<unsigned>(low)) + 1;
  if (distance_ > given_) return damaged("a reference points before their beginning");
  return success();
}

Status LzfStream::read(std::span<std::byte> out) {
  for (auto& byte : out) {
    if (left_ == 0) {
      BOOST_OUTCOME_TRYV(next_instruction());
    }
    if (distance_ == 0) {
      BOOST_OUTCOME_TRY(literal, take());
      byte = literal;
    } else {
      byte = window_[(given_ - distance_) % window_bytes];
    }
    window_[given_ % window_bytes] = byte;
    ++given_;
    --left_;
  }
  return success();
}

Status LzfStream::skip(std::uint64_t bytes) {
  std::array<std::byte, 4096> thrown;
  while (bytes > 0) {
    const auto n = static_cast<std::size_t>(std::min<std::uint64_t>(thrown.size(), bytes));
    BOOST_OUTCOME_TRYV(read(std::span(thrown).first(n)));
    bytes -= n;
  }
  return success();
}

}  // namespace tessera
