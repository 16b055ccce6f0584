#include "src/result/store/byte_planes.h"

#include <zstd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <new>

namespace tessera::store {

namespace {

// 16 numbers, or 16 bytes of each of their planes: 128 bytes.
using Lane = unsigned char __attribute__((vector_size(16)));
struct Square {
  Lane lanes[8];
};

// Interleaves the two halves of the square. The byte at place b moves to the place whose seven bits are those of b
// rotated left by one, because it comes to stand beside the byte half a square away. The place of byte `plane` of
// number `i` is i * 8 + plane in the order of numbers, and plane * 16 + i in the order of planes: another such
// rotation. So three steps lead from planes to numbers, and four lead back.
void rotate(Square& square) {
  Square to;
  for (int i = 0; i < 4; ++i) {
    const Lane a = square.lanes[i], b = square.lanes[i + 4];
    to.lanes[2 * i] = __builtin_shufflevector(a, b, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
    to.lanes[2 * i + 1] = __builtin_shufflevector(a, b, 8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31);
  }
  square = to;
}

struct FreeZstd {
  void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};
// One context a thread: setting up its tables takes longer than packing a small tile.
template <class Context>
std::unique_ptr<Context, FreeZstd> held(Context* context) {
  if (context == nullptr) throw std::bad_alloc();
  return std::unique_ptr<Context, FreeZstd>(context);
}

}  // namespace

void split_planes(std::span<const std::uint64_t> numbers, std::byte* to, std::size_t stride) {
  std::size_t i = 0;
  for (; i + 16 <= numbers.size(); i += 16) {
    Square square;
    std::memcpy(square.lanes, &numbers[i], sizeof square);
    for (int step = 0; step < 4; ++step) rotate(square);
    for (std::size_t p = 0; p < planes_max; ++p) std::memcpy(to + p * stride + i, &square.lanes[p], sizeof(Lane));
  }
  for (; i < numbers.size(); ++i)
    for (std::size_t p = 0; p < planes_max; ++p) to[p * stride + i] = static_cast<std::byte>(numbers[i] >> 8 * p);
}

void join_planes(std::span<const std::byte* const> planes, std::span<std::uint64_t> numbers) {
  static constexpr std::byte zeros[sizeof(Lane)] = {};
  std::array<const std::byte*, planes_max> at;
  std::array<std::size_t, planes_max> step;
  for (std::size_t p = 0; p < planes_max; ++p) {
    at[p] = p < planes.size() ? planes[p] : zeros;
    step[p] = p < planes.size() ? 1 : 0;
  }
  std::size_t i = 0;
  for (; i + 16 <= numbers.size(); i += 16) {
    Square square;
    for (std::size_t p = 0; p < planes_max; ++p) std::memcpy(&square.lanes[p], at[p] + i * step[p], sizeof(Lane));
    for (int turn = 0; turn < 3; ++turn) rotate(square);
    std::memcpy(&numbers[i], square.lanes, sizeof square);
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
