#include "src/tiling/hilbert.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>

namespace tessera {
namespace {

// Hamilton's state is an entry corner e and a direction d of the sub-cube. One step of the table handles `Levels`
// levels.
template <int Dim, int Levels>
struct Curve {
  static constexpr int bits = Dim * Levels;
  static constexpr unsigned corners = 1u << Dim;
  static constexpr unsigned states = corners * Dim;
  // Low `bits` bits: this part of the key. Above them: the next state.
  using Table = std::array<std::array<std::uint16_t, std::size_t{1} << bits>, states>;

  static constexpr unsigned rotate_left(unsigned b, unsigned n) {
    n %= Dim;
    return ((b << n) | (b >> (Dim - n))) & (corners - 1);
  }
  static constexpr unsigned gray(unsigned i) { return i ^ (i >> 1); }
  static constexpr unsigned gray_inverse(unsigned g) {
    unsigned i = 0;
    for (; g != 0; g >>= 1) i ^= g;
    return i;
  }
  static constexpr unsigned entry(unsigned w) { return w == 0 ? 0 : gray(2 * ((w - 1) / 2)); }
  static constexpr unsigned direction(unsigned w) {
    if (w == 0) return 0;
    return static_cast<unsigned>(std::countr_one(w % 2 == 0 ? w - 1 : w)) % Dim;
  }

  static constexpr Table make() {
    Table table{};
    for (unsigned state = 0; state < states; ++state) {
      for (unsigned interleaved = 0; interleaved < (1u << bits); ++interleaved) {
        unsigned e = state / Dim;
        unsigned d = state % Dim;
        unsigned key = 0;
        for (int level = Levels - 1; level >= 0; --level) {
          const unsigned corner = (interleaved >> (level * Dim)) & (corners - 1);
          const unsigned w = gray_inverse(rotate_left(corner ^ e, Dim - (d + 1) % Dim));
          key = (key << Dim) | w;
          e ^= rotate_left(entry(w), d + 1);
          d = (d + direction(w) + 1) % Dim;
        }
        table[state][interleaved] = static_cast<std::uint16_t>(((e * Dim + d) << bits) | key);
      }
    }
    return table;
  }

  static std::uint64_t key(const Table& table, std::uint64_t interleaved, int steps) {
    constexpr std::uint64_t mask = (std::uint64_t{1} << bits) - 1;
    std::uint64_t result = 0;
    unsigned state = 0;
    for (int step = steps - 1; step >= 0; --step) {
      const std::uint16_t next = table[state][(interleaved >> (step * bits)) & mask];
      result = (result << bits) | (next & mask);
      state = next >> bits;
    }
    return result;
  }
};

using Curve3 = Curve<3, 3>;  // 24 KB of table, 7 steps for 21 bits
using Curve2 = Curve<2, 4>;  // 4 KB of table, 8 steps for 32 bits, the first of which is always 0
constexpr Curve3::Table table_3 = Curve3::make();
constexpr Curve2::Table table_2 = Curve2::make();

// Puts two zero bits before each of the 21 bits of v.
std::uint64_t spread_3(std::uint64_t v) {
  v = (v | v << 32) & 0x001f00000000ffff;
  v = (v | v << 16) & 0x001f0000ff0000ff;
  v = (v | v << 8) & 0x100f00f00f00f00f;
  v = (v | v << 4) & 0x10c30c30c30c30c3;
  return (v | v << 2) & 0x1249249249249249;
}

// Puts one zero bit before each of the 32 bits of v.
std::uint64_t spread_2(std::uint64_t v) {
  v = (v | v << 16) & 0x0000ffff0000ffff;
  v = (v | v << 8) & 0x00ff00ff00ff00ff;
  v = (v | v << 4) & 0x0f0f0f0f0f0f0f0f;
  v = (v | v << 2) & 0x3333333333333333;
  return (v | v << 1) & 0x5555555555555555;
}

// Returns x, but at most `most`; 0 also for NaN (a flat axis whose prescaled coordinate overflows).
std::uint64_t clamped(double x, double most) { return x > 0 ? static_cast<std::uint64_t>(std::min(x, most)) : 0; }

}  // namespace

HilbertKey::HilbertKey(const Bounds& bounds, int dimension) : dimension_(dimension) {
  if (bounds.empty()) return;
  double longest = 0;
  for (int a = 0; a < dimension; ++a) longest = std::max(longest, bounds.hi[a] - bounds.lo[a]);
  if (longest == 0) return;
  if (!std::isfinite(longest)) prescale_ = 0.25;
  if (longest < 0x1p-900) prescale_ = 0x1p300;
  double scaled = 0;
  for (int a = 0; a < dimension; ++a) {
    origin_[a] = bounds.lo[a] * prescale_;
    const double side = bounds.hi[a] * prescale_ - origin_[a];
    if (side > scaled) scaled = side;
  }
  scale_ = (dimension == 2 ? 0x1p31 : 0x1p21) / scaled;
}

std::uint64_t HilbertKey::operator()(const Point& p) const {
  const double x = (p.x * prescale_ - origin_.x) * scale_;
  const double y = (p.y * prescale_ - origin_.y) * scale_;
  if (dimension_ == 2) {
    constexpr double most = 0x1p31 - 1;
    return Curve2::key(table_2, spread_2(clamped(x, most)) | spread_2(clamped(y, most)) << 1, 8);
  }
  const double z = (p.z * prescale_ - origin_.z) * scale_;
  constexpr double most = 0x1p21 - 1;
  return Curve3::key(table_3,
                     spread_3(clamped(x, most)) | spread_3(clamped(y, most)) << 1 | spread_3(clamped(z, most)) << 2, 7);
}

}  // namespace tessera
