// gzip and Zstandard streams, and what has neither, from a source that is read once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/input/format.h"

namespace tessera {

// Bytes from somewhere, with a look ahead.
class InputBuffer {
 public:
  // Fills a part of its argument, from the begin, and returns its length; 0 at the end.
  using Read = std::function<Result<std::size_t>(std::span<std::byte>)>;
  explicit InputBuffer(Read read);

  // The next bytes, at least `least` of them unless the end comes before. REQUIRES: least <= block_bytes.
  Result<std::span<const std::byte>> peek(std::size_t least = 1);
  void skip(std::size_t bytes);  // REQUIRES: not more than peek() gave last
  // What has been skipped.
  std::uint64_t position() const { return position_; }

  static constexpr std::size_t block_bytes = std::size_t{1} << 18;

 private:
  Read read_;
  std::vector<std::byte> block_;
  std::size_t begin_ = 0, end_ = 0;
  bool at_end_ = false;
  std::uint64_t position_ = 0;
};

// Takes bytes, in order.
using ByteSink = std::function<Status(std::span<const std::byte>)>;

// "gzip" or "zstd"; "" for what is no packing.
const char* packing_name(FileFormat format);

// Gives `sink` all that is in `in`, in blocks of 256 KiB and a shorter last one; memory does not depend on how large it
// becomes. `packing`: any other than gzip and zstd is copied as it is. Several gzip members or Zstandard frames are one
// stream, as their tools have it. Errors bad_input, "NAME: ...": damaged, cut off, or followed by what is no such
// stream.
Status unpack(FileFormat packing, InputBuffer& in, const std::string& name, const ByteSink& sink);

}  // namespace tessera
