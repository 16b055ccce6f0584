// The bytes of one compressed stream, read from the file in pieces, so that memory does not depend on what a file
// claims.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"

namespace tessera::laz {

// Gives the bytes begin..end of `source` one after the other, and then zeros, which missing() counts. So a decoder need
// not check for the end at each byte; its caller checks after a block of points.
class ByteFeed {
 public:
  ByteFeed() = default;
  // REQUIRES: begin <= end <= source.size(); `source` outlives this.
  ByteFeed(const ByteSource& source, std::uint64_t begin, std::uint64_t end)
      : source_(&source), next_(begin), end_(end) {}

  std::uint8_t byte() {
    if (at_ == stop_) [[unlikely]]
      refill();
    return *at_++;
  }
  // The file offset of the byte that byte() would return next.
  std::uint64_t position() const { return next_ - static_cast<std::uint64_t>(stop_ - at_); }
  std::uint64_t end() const { return end_; }
  // The number of zeros that were returned after the end.
  std::uint64_t missing() const { return zeros_ - (zeros_ > 0 ? static_cast<std::uint64_t>(stop_ - at_) : 0); }
  // The first error of the source. After an error byte() returns zeros.
  const Status& status() const { return status_; }

 private:
  void refill();

  const ByteSource* source_ = nullptr;
  std::uint64_t next_ = 0, end_ = 0, zeros_ = 0;
  const std::uint8_t* at_ = nullptr;
  const std::uint8_t* stop_ = nullptr;
  std::vector<std::uint8_t> piece_;
  Status status_ = success();
};

}  // namespace tessera::laz
