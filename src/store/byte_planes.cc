#include "src/store/byte_planes.h"

#include <zstd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <new>

namespace tessera::store {

namespace {

// Eight rows of eight bytes become columns: squares of four bytes are swapped, then of two, then of one.
using Square = std::array<std::uint64_t, 8>;
template <std::size_t half, std::uint64_t low>
void swap_quarters(Square& square) {
  for (std::size_t i = 0; i < 8; ++i) {
    if ((i & half) != 0) continue;
    const std::uint64_t swapped = (square[i] >> 8 * half ^ square[i + half]) & low;
    square[i + half] ^= swapped;
    square[i] ^= swapped << 8 * half;
  }
}
void transpose(Square& square) {
  swap_quarters<4, 0x00000000ffffffff>(square);
  swap_quarters<2, 0x0000ffff0000ffff>(square);
  swap_quarters<1, 0x00ff00ff00ff00ff>(square);
}

struct FreeZstd {
  void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};
// One for each thread: setting up its tables takes longer than packing a small tile.
template <class Context>
std::unique_ptr<Context, FreeZstd> held(Context* context) {
  if (context == nullptr) throw std::bad_alloc();
  return std::unique_ptr<Context, FreeZstd>(context);
}

}  // namespace

void split_planes(std::span<const std::uint64_t> numbers, std::byte* to, std::size_t stride) {
  std::size_t i = 0;
  for (; i + 8 <= numbers.size(); i += 8) {
    Square square;
    std::memcpy(square.data(), &numbers[i], sizeof square);
    transpose(square);
    for (std::size_t p = 0; p < planes_max; ++p) std::memcpy(to + p * stride + i, &square[p], 8);
  }
  for (; i < numbers.size(); ++i)
    for (std::size_t p = 0; p < planes_max; ++p) to[p * stride + i] = static_cast<std::byte>(numbers[i] >> 8 * p);
}

void join_planes(std::span<const std::byte* const> planes, std::span<std::uint64_t> numbers) {
  std::size_t i = 0;
  for (; i + 8 <= numbers.size(); i += 8) {
    Square square{};
    for (std::size_t p = 0; p < planes.size(); ++p) std::memcpy(&square[p], planes[p] + i, 8);
    transpose(square);
    std::memcpy(&numbers[i], square.data(), sizeof square);
  }
  for (; i < numbers.size(); ++i) {
    numbers[i] = 0;
    for (std::size_t p = 0; p < planes.size(); ++p) numbers[i] |= static_cast<std::uint64_t>(planes[p][i]) << 8 * p;
  }
}

std::size_t pack_plane(std::span<const std::byte> plane, std::byte* to, std::size_t room) {
  thread_local const auto context = held(ZSTD_createCCtx());
  constexpr int level = 1;
  const std::size_t size = ZSTD_compressCCtx(context.get(), to, room, plane.data(), plane.size(), level);
  return ZSTD_isError(size) != 0 ? 0 : size;
}

bool unpack_plane(std::span<const std::byte> from, std::span<std::byte> plane) {
  thread_local const auto context = held(ZSTD_createDCtx());
  return ZSTD_getFrameContentSize(from.data(), from.size()) == plane.size() &&
         ZSTD_findFrameCompressedSize(from.data(), from.size()) == from.size() &&
         ZSTD_decompressDCtx(context.get(), plane.data(), plane.size(), from.data(), from.size()) == plane.size();
}

}  // namespace tessera::store
