// In 2D points of equal x and y are one vertex, whatever their heights: which of them it is.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "src/base/ids.h"

namespace tessera {

// By source index, or by height; of equal heights the first.
enum class DuplicatePolicy : std::uint8_t { first, last, lowest, highest };

inline constexpr std::array<std::string_view, 4> kept_point_names{"first", "last", "lowest", "highest"};
inline std::string_view name_of(DuplicatePolicy keep) { return kept_point_names[static_cast<std::size_t>(keep)]; }
inline std::optional<DuplicatePolicy> kept_point_of(std::string_view name) {
  for (std::size_t i = 0; i < kept_point_names.size(); ++i)
    if (kept_point_names[i] == name) return static_cast<DuplicatePolicy>(i);
  return std::nullopt;
}
inline bool is_by_height(DuplicatePolicy keep) {
  return keep == DuplicatePolicy::lowest || keep == DuplicatePolicy::highest;
}

struct KeptCandidate {
  PointId id;
  double height = 0;  // looked at only when it matters
};

// Whether `a` is kept of the two: a strict order. A height that is no number is kept when there is no other alone.
inline bool is_kept_before(DuplicatePolicy keep, const KeptCandidate& a, const KeptCandidate& b) {
  if (keep == DuplicatePolicy::last) return b.id < a.id;
  if (is_by_height(keep)) {
    if (std::isnan(a.height) != std::isnan(b.height)) return std::isnan(b.height);
    const double low = keep == DuplicatePolicy::lowest ? a.height : b.height;
    const double high = keep == DuplicatePolicy::lowest ? b.height : a.height;
    if (low < high || high < low) return low < high;
  }
  return a.id < b.id;
}

// No number is at the height of no number.
inline bool is_same_height(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

}  // namespace tessera
