// Writes features of maps as GeoJSON, in longitude and latitude or in the result's coordinates.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "src/base/crs/lon_lat.h"
#include "src/base/point.h"
#include "src/base/result.h"

namespace tessera::service {

// True if a line, or the area of a ring whose last point is the first, has a point in common with a closed box.
bool line_meets(std::span<const Point> line, const Bounds& box);
bool ring_meets(std::span<const Point> ring, const Bounds& box);

// Returns a closed ring with points between the corners, so that its sides follow those on the ground when projected.
std::vector<Point> dense_ring(std::span<const Point> corners);

// The coordinate systems of the features in the answer, and of the box in the question.
struct MapForm {
  bool stored = false, stored_box = false;  // in the result's coordinates; else in longitude and latitude
  bool swapped = false;                     // the result's coordinates are written, and expected, with y before x
};

// Collects a page of features.
class FeaturePage {
 public:
  // Collects at most `limit` features that meet `box`, if there is one. The box has x before y, whatever `form` says.
  FeaturePage(const LonLat& places, const std::optional<Bounds>& box, std::uint64_t limit, MapForm form)
      : places_(places), box_(box), form_(form), limit_(limit) {}

  enum class Kind : bool { ring, line };
  // Adds a feature. Returns false when it belongs to the next page; then no more features are needed. `points` are in
  // the result's coordinates; `third` is the third coordinate of all points, if they have one.
  Result<bool> add(std::uint64_t id, const nlohmann::ordered_json& properties, Kind kind, std::vector<Point> points,
                   std::optional<double> third = {});

  std::uint64_t count() const { return count_; }
  std::uint64_t last() const { return last_; }  // id of the last feature. REQUIRES: there is one
  bool full() const { return full_; }
  // Returns the features, separated by commas.
  std::string take() { return std::move(text_); }

 private:
  static constexpr std::uint64_t points_max = 500'000;  // of a page; a single feature may have more

  const LonLat& places_;
  std::optional<Bounds> box_;
  MapForm form_;
  std::uint64_t limit_, count_ = 0, points_ = 0, last_ = 0;
  bool full_ = false;
  std::string text_;
};

}  // namespace tessera::service
