#include "src/input/bytes/record_stream.h"

#include <algorithm>

namespace tessera {

Status RecordStream::check_size() const {
  const std::uint64_t there = source_->size() > offset_ ? (source_->size() - offset_) / record_bytes_ : 0;
  if (count_ <= there) return success();
  return error(Errc::bad_input, source_->path().string() + ", record " + std::to_string(there) +
                                    ": the file ends before or within this record, but its header promises " +
                                    std::to_string(count_) + " records");
}

Result<std::span<const std::byte>> RecordStream::next(std::size_t most) {
  const std::size_t fitting = std::max<std::size_t>(1, block_bytes_max / record_bytes_);
  const auto n = static_cast<std::size_t>(
      std::min<std::uint64_t>(count_ - position_, std::min({most, batch_points_max, fitting})));
  first_ = position_;
  if (n == 0) {
    BOOST_OUTCOME_TRYV(source_->check_unchanged());
    return std::span<const std::byte>();
  }
  if (block_.size() < n * record_bytes_) block_.resize(n * record_bytes_);
  const std::span<std::byte> bytes(block_.data(), n * record_bytes_);
  BOOST_OUTCOME_TRYV(source_->read(offset_ + position_ * record_bytes_, bytes));
  position_ += n;
  return std::span<const std::byte>(bytes);
}

}  // namespace tessera
