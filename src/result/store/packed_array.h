// Arrays as VTK XML files hold them with vtkZLibDataCompressor: a table of sizes, then blocks, each a zlib stream.
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

// Bytes of a block before it is packed. One stored block of deflate holds at most 65535; 65520 is a whole number of
// all types, of points, and of rows of 3 or 4 numbers.
inline constexpr std::uint64_t block_bytes = 65520;
// What a plain block has more than its bytes: two of zlib, five of deflate, and a checksum.
inline constexpr std::uint64_t plain_head_bytes = 7, plain_extra_bytes = plain_head_bytes + 4;

// zlib's header; then: the last block, stored; its size, and that inverted. REQUIRES: size < 2^16.
constexpr std::array<std::byte, plain_head_bytes> plain_head(std::uint64_t size) {
  const auto low = [](std::uint64_t value) { return static_cast<std::byte>(value & 0xff); };
  return {std::byte{0x78}, std::byte{0x01}, std::byte{0x01}, low(size), low(size >> 8u), low(~size), low(~size >> 8u)};
}

constexpr std::uint64_t block_count(std::uint64_t bytes) { return (bytes + block_bytes - 1) / block_bytes; }
// Of `bytes` as plain blocks.
constexpr std::uint64_t plain_bytes(std::uint64_t bytes) { return bytes + block_count(bytes) * plain_extra_bytes; }
// Of the table before the blocks.
constexpr std::uint64_t table_bytes(std::uint64_t blocks) { return 8 * (3 + blocks); }

class PackedArray {
 public:
  // `bytes` are copied when they are written, and must stay until then.
  static PackedArray plain(std::span<const std::byte> bytes);
  // As many bytes, made when they are written: `make` gives them in pieces and ends when one is not taken.
  using Take = std::function<Status(std::span<const std::byte>)>;
  using Make = std::function<Status(const Take&)>;
  // Of the first `written`, whole blocks, only the table is written: their blocks stand in the file already.
  static PackedArray streamed(std::uint64_t bytes, Make make, std::uint64_t written = 0);
  // Elements of `size` bytes, 1, 2 or 4, that hardly change.
  static PackedArray runs(std::span<const std::byte> bytes, std::size_t size);
  // `count` times these bytes, 1, 2 or 4.
  static PackedArray repeated(std::span<const std::byte> value, std::uint64_t count);
  // step, 2 step, ..., cells step as i32. Blocks are the same in every tile, so the first ones are made once a process.
  // Throws Stopped soon after `stop` is requested: of large tiles this takes a second.
  static PackedArray offsets(std::uint64_t cells, int step, const std::stop_token& stop = {});

  std::uint64_t file_bytes() const;
  // From `offset` on.
  Status write(DirectWriter& file, std::uint64_t offset) const;

 private:
  using Block = std::shared_ptr<const std::vector<std::byte>>;

  std::uint64_t bytes_ = 0;    // before packing
  std::uint64_t written_ = 0;  // of them
  Make make_;                  // of plain ones, which have no blocks_
  std::vector<Block> blocks_;
};

// The plain blocks of as many bytes, without a table.
Status write_plain(std::uint64_t bytes, const PackedArray::Make& make, DirectWriter& file);

}  // namespace tessera::store
