#include "src/result/store/grid_scale.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>

namespace tessera::store {

namespace {

constexpr std::array<double, 5> factors{1, 2, 4, 5, 8};
constexpr std::uint8_t decimals = 50;  // codes 1 to 50: 1 + 5 j + f is factor f of 10^j
constexpr int first_power = 4;         // 2^4 to 2^53 have codes 51 to 100: lower powers are among the decimals
constexpr std::uint8_t scale_codes = 100;
constexpr std::uint8_t multiplying = 128;  // is added to the code

struct Candidate {
  double scale = 0;
  std::uint8_t code = 0;
};

constexpr std::array<Candidate, scale_codes> make_candidates() {
  std::array<Candidate, scale_codes> made{};
  double ten = 1;
  std::uint8_t code = 1;
  for (int j = 0; j < 10; ++j, ten *= 10)
    for (const double factor : factors) {
      made[code - 1u] = {factor * ten, code};
      ++code;
    }
  double two = 1 << first_power;
  for (; code <= scale_codes; ++code, two *= 2) made[code - 1u] = {two, code};
  return made;
}
constexpr auto by_code = make_candidates();

constexpr auto by_scale = [] {
  auto sorted = by_code;
  std::sort(sorted.begin(), sorted.end(), [](const Candidate& a, const Candidate& b) { return a.scale < b.scale; });
  return sorted;
}();

// How well a prediction fits.
struct Fit {
  bool exact = true, near = true;
  std::uint64_t sum = 0;
  void add(double value, double predicted) {
    constexpr std::uint64_t near_at_most = 4;  // units in the last place, in both directions
    const std::uint64_t off =
        folded(ordered(std::bit_cast<std::uint64_t>(value)) - ordered(std::bit_cast<std::uint64_t>(predicted)));
    exact &= off == 0 || value == 0;  // -0
    near &= off <= 2 * near_at_most;
    sum += off;
  }
};

}  // namespace

std::optional<GridScale> GridScale::of_code(std::uint8_t code) {
  const bool multiplies = code > multiplying;
  const std::uint8_t plain = multiplies ? code - multiplying : code;
  if (plain < 1 || plain > (multiplies ? decimals : scale_codes)) return {};
  return GridScale(code, by_code[plain - 1u].scale, multiplies || plain > decimals);
}

std::optional<GridScale> GridFinder::next(std::span<const double> values) {
  // Larger multiples come near to most doubles, so a good fit may be an accident.
  constexpr double no_accident = 0x1p42;
  if (std::ranges::none_of(values, &GridFinder::counts)) return {};
  while (next_ < by_scale.size()) {
    const Candidate candidate = by_scale[next_++];
    const GridScale divides(candidate.code, candidate.scale, candidate.code > decimals);
    const GridScale multiplies(candidate.code + multiplying, candidate.scale, true);
    Fit by_division, by_product;
    bool far = true;  // too far from doubles for an accident
    for (const double value : values) {
      if (!counts(value)) continue;
      if (!counts(value * candidate.scale)) return {};  // larger scales are out of range, too
      const std::int64_t k = divides.multiple(value);
      by_division.add(value, divides.prediction(k));
      by_product.add(value, multiplies.prediction(k));
      far &= std::abs(value * candidate.scale) < no_accident;
      if (!by_division.exact && !by_product.exact && !(far && (by_division.near || by_product.near))) break;
    }
    if (by_division.exact) return divides;
    if (by_product.exact) return multiplies;
    if (far && by_division.near && (!by_product.near || by_division.sum <= by_product.sum)) return divides;
    if (far && by_product.near) return multiplies;
  }
  return {};
}

}  // namespace tessera::store
