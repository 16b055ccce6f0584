#include "src/result/store/deflate_runs.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

#include "src/result/store/block_sum.h"
#include "src/result/store/packed_array.h"

namespace tessera::store {
namespace {

// `count` bits as they are in the stream: codes begin with their highest bit, numbers with their lowest.
struct Bits {
  std::uint32_t bits = 0, count = 0;
};

constexpr Bits code(std::uint32_t value, std::uint32_t count) {
  std::uint32_t bits = 0;
  for (std::uint32_t i = 0; i < count; ++i) bits |= (value >> i & 1) << (count - 1 - i);
  return {bits, count};
}

// RFC 1951, 3.2.6: the fixed code of literals, the end and lengths.
constexpr Bits symbol(std::uint32_t s) {
  if (s < 144) return code(0x30 + s, 8);
  if (s < 256) return code(0x190 + s - 144, 9);
  if (s < 280) return code(s - 256, 7);
  return code(0xc0 + s - 280, 8);
}

constexpr std::uint32_t match_min = 3, match_max = 258, end_of_block = 256;

struct Codes {
  std::array<Bits, 256> literal;
  std::array<Bits, match_max + 1> length;
};

// RFC 1951, 3.2.5: lengths from 3 on, with four symbols for each number of extra bits, and eight for none; 258 has its
// own symbol.
constexpr Codes codes = [] {
  Codes all{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) all.literal[byte] = symbol(byte);
  std::uint32_t length = match_min;
  for (std::uint32_t s = 257; s < 285; ++s) {
    const std::uint32_t extra = s < 265 ? 0 : (s - 261) / 4;
    for (std::uint32_t i = 0; i < 1u << extra && length < match_max; ++i, ++length) {
      const Bits head = symbol(s);
      all.length[length] = {head.bits | i << head.count, head.count + extra};
    }
  }
  all.length[match_max] = symbol(285);
  return all;
}();

class BitWriter {
 public:
  explicit BitWriter(std::byte* to) : to_(to) {}
  void put(Bits bits) {
    waiting_ |= std::uint64_t{bits.bits} << count_;
    count_ += bits.count;
    if (count_ < 32) return;
    static_assert(std::endian::native == std::endian::little);
    std::memcpy(to_, &waiting_, 4);
    to_ += 4;
    waiting_ >>= 32;
    count_ -= 32;
  }
  std::byte* end() {
    for (; count_ > 0; count_ -= std::min(count_, 8u), waiting_ >>= 8) *to_++ = static_cast<std::byte>(waiting_ & 0xff);
    return to_;
  }

 private:
  std::byte* to_;
  std::uint64_t waiting_ = 0;
  std::uint32_t count_ = 0;
};

// The number of bytes from `at` on that equal the bytes `distance` before them.
std::size_t run(std::span<const std::byte> bytes, std::size_t at, std::size_t distance) {
  const std::size_t begin = at;
  for (std::uint64_t now = 0, before = 0; at + sizeof now <= bytes.size(); at += sizeof now) {
    std::memcpy(&now, bytes.data() + at, sizeof now);
    std::memcpy(&before, bytes.data() + at - distance, sizeof before);
    if (now != before) return at - begin + static_cast<std::size_t>(std::countr_zero(now ^ before)) / 8;
  }
  while (at < bytes.size() && bytes[at] == bytes[at - distance]) ++at;
  return at - begin;
}

// Writes a run of at least match_min bytes in pieces, none of them shorter than match_min.
void put_run(BitWriter& out, std::size_t size, Bits distance) {
  const auto put = [&](std::size_t length) {
    out.put(codes.length[length]);
    out.put(distance);
    size -= length;
  };
  while (size == match_max || size >= match_max + match_min) put(match_max);
  if (size > match_max) put(size - match_min);
  if (size > 0) put(size);
}

std::vector<std::byte> stored(std::span<const std::byte> bytes, const BlockChecksum& sum) {
  std::vector<std::byte> packed(bytes.size() + plain_extra_bytes);
  auto end = std::ranges::copy(plain_head(bytes.size()), packed.begin()).out;
  end = std::ranges::copy(bytes, end).out;
  std::ranges::copy(sum.bytes(), end);
  return packed;
}

}  // namespace

std::vector<std::byte> deflate_runs(std::span<const std::byte> bytes, std::size_t size) {
  BlockChecksum sum;
  sum.add(bytes);
  const Bits distance = code(static_cast<std::uint32_t>(size) - 1, 5);
  std::vector<std::byte> packed(2 + bytes.size() * 9 / 8 + 16);  // at most 9 bits a byte
  packed[0] = std::byte{0x78};
  packed[1] = std::byte{0x01};
  BitWriter out(packed.data() + 2);
  out.put({3, 3});  // the last block, with the fixed codes
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t same = at < size ? 0 : run(bytes, at, size);
    if (same < match_min) {
      out.put(codes.literal[static_cast<std::size_t>(bytes[at])]);
      ++at;
    } else {
      put_run(out, same, distance);
      at += same;
    }
  }
  out.put(symbol(end_of_block));
  std::byte* const end = std::ranges::copy(sum.bytes(), out.end()).out;
  packed.resize(static_cast<std::size_t>(end - packed.data()));
  if (packed.size() > bytes.size() + plain_extra_bytes) return stored(bytes, sum);
  packed.shrink_to_fit();
  return packed;
}

}  // namespace tessera::store
