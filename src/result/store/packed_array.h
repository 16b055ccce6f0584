// Arrays as VTK XML files store them with vtkZLibDataCompressor: a table of sizes, then blocks, each a zlib stream.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <stop_token>
#include <vector>

#include "src/base/result.h"
#include "src/result/store/direct_writer.h"

namespace tessera::store {

// Bytes of a block before packing. A stored block of deflate holds at most 65535 bytes. 65520 is a multiple of the size
// of every type, of a point, and of rows of 3 or 4 numbers.
inline constexpr std::uint64_t block_bytes = 65520;
// What a plain block has in addition to its bytes: two bytes of zlib, five of deflate, and a checksum.
inline constexpr std::uint64_t plain_head_bytes = 7, plain_extra_bytes = plain_head_bytes + 4;

// The header of zlib, then that of a last and stored block of deflate: its size, and the inverted size. REQUIRES: size
// < 2^16.
constexpr std::array<std::byte, plain_head_bytes> plain_head(std::uint64_t size) {
  const auto low = [](std::uint64_t value) { return static_cast<std::byte>(value & 0xff); };
  return {std::byte{0x78}, std::byte{0x01}, std::byte{0x01}, low(size), low(size >> 8u), low(~size), low(~size >> 8u)};
}

constexpr std::uint64_t block_count(std::uint64_t bytes) { return (bytes + block_bytes - 1) / block_bytes; }
// The size of `bytes` bytes as plain blocks.
constexpr std::uint64_t plain_bytes(std::uint64_t bytes) { return bytes + block_count(bytes) * plain_extra_bytes; }
// The size of the table before the blocks.
constexpr std::uint64_t table_bytes(std::uint64_t blocks) { return 8 * (3 + blocks); }

class PackedArray {
 public:
  // An array of plain blocks. `bytes` are copied when they are written, and must stay valid until then.
  static PackedArray plain(std::span<const std::byte> bytes);
  // An array of `bytes` bytes in plain blocks, which `make` makes when they are written. `make` passes the bytes on in
  // pieces, and ends when a piece is refused.
  using Consumer = std::function<Status(std::span<const std::byte>)>;
  using Make = std::function<Status(const Consumer&)>;
  // For the first `written` bytes, which are whole blocks, only the table is written: their blocks are in the file
  // already.
  static PackedArray streamed(std::uint64_t bytes, Make make, std::uint64_t written = 0);
  // A deflated array of elements of `size` bytes, 1, 2 or 4, that hardly change.
  static PackedArray runs(std::span<const std::byte> bytes, std::size_t size);
  // An array that repeats `value`, of 1, 2 or 4 bytes, `count` times.
  static PackedArray repeated(std::span<const std::byte> value, std::uint64_t count);
  // The array step, 2 step, ..., cells step as i32. Its blocks are the same in every tile, so the first ones are made
  // once in a process. Throws Stopped soon after `stop` is requested, because a large tile takes a second.
  static PackedArray offsets(std::uint64_t cells, int step, const std::stop_token& stop = {});

  std::uint64_t file_bytes() const;
  // Writes the array at `offset`.
  Status write(DirectWriter& file, std::uint64_t offset) const;

 private:
  using Block = std::shared_ptr<const std::vector<std::byte>>;

  std::uint64_t bytes_ = 0;    // before packing
  std::uint64_t written_ = 0;  // bytes whose blocks are in the file already
  Make make_;                  // of plain arrays, which have no blocks_
  std::vector<Block> blocks_;
};

// Writes `bytes` bytes in plain blocks, without a table.
Status write_plain(std::uint64_t bytes, const PackedArray::Make& make, DirectWriter& file);

}  // namespace tessera::store
