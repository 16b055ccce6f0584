// Which of several points with equal coordinates is kept as the vertex. In 2D points of equal x and y are one vertex,
// whatever their heights.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "src/base/ids.h"

namespace tessera {

// The rule: by source index, or by height. Of points with equal heights the first is kept.
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
  double height = 0;  // used by the policies lowest and highest only
};

// Whether `a` is kept and `b` is not: a strict order. A height that is NaN loses against every number.
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

// Whether two heights are equal. NaN counts as equal to NaN.
inline bool is_same_height(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

}  // namespace tessera
