// Unpacks gzip and Zstandard streams, or copies other bytes, from a source that is read once.
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

// Bytes from a function, which can be looked at before they are taken.
class InputBuffer {
 public:
  // Fills the beginning of its argument and returns the number of bytes; 0 at the end.
  using Read = std::function<Result<std::size_t>(std::span<std::byte>)>;
  explicit InputBuffer(Read read);

  // The next bytes: at least `least`, unless the end comes before. REQUIRES: least <= block_bytes.
  Result<std::span<const std::byte>> peek(std::size_t least = 1);
  void skip(std::size_t bytes);  // REQUIRES: at most as many as peek() gave last
  // The number of bytes that were skipped.
  std::uint64_t position() const { return position_; }

  static constexpr std::size_t block_bytes = std::size_t{1} << 18;

 private:
  Read read_;
  std::vector<std::byte> block_;
  std::size_t begin_ = 0, end_ = 0;
  bool at_end_ = false;
  std::uint64_t position_ = 0;
};

// A function that takes bytes in order.
using ByteSink = std::function<Status(std::span<const std::byte>)>;

// "gzip" or "zstd"; "" for other formats.
const char* packing_name(FileFormat format);

// Gives `sink` the whole content of `in`, in blocks of 256 KiB and a shorter last one. Memory does not depend on the
// size of the content. With a `packing` other than gzip and zstd the bytes are copied. Several gzip members or
// Zstandard frames count as one stream, as for their own tools. Error bad_input, "NAME: ...": the stream is damaged,
// cut off, or followed by other bytes.
Status unpack(FileFormat packing, InputBuffer& in, const std::string& name, const ByteSink& sink);

}  // namespace tessera
