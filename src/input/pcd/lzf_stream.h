// LZF (Marc Lehmann's LibLZF, format of version 1): unpacks forward, with the last 8 KiB in memory. PCD files use it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"

namespace tessera {

// Unpacks the bytes [offset, offset + packed_bytes) of a source. The source must live longer.
class LzfStream {
 public:
  LzfStream(const ByteSource& source, std::uint64_t offset, std::uint64_t packed_bytes)
      : source_(&source), at_(offset), end_(offset + packed_bytes) {}

  // Fills `out` with the next bytes. Error bad_input if the packed bytes end before, or refer to bytes before the
  // beginning.
  Status read(std::span<std::byte> out);
  Status skip(std::uint64_t bytes);

 private:
  static constexpr std::size_t window_bytes = std::size_t{1} << 13;  // the farthest reference

  Result<std::byte> take();
  // Reads the next instruction. REQUIRES: nothing is left of the last one.
  Status next_instruction();
  Error damaged(const char* what) const;

  const ByteSource* source_;
  std::uint64_t at_, end_;
  std::vector<std::byte> block_;
  std::size_t block_begin_ = 0;
  std::array<std::byte, window_bytes> window_{};
  std::uint64_t given_ = 0;     // the number of bytes that were unpacked
  std::size_t left_ = 0;        // the number of bytes that the instruction still gives
  std::uint64_t distance_ = 0;  // how far back a reference points; 0 for literal bytes
};

}  // namespace tessera
