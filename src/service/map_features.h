// Features of maps as GeoJSON, in longitude and latitude or as the result has them.
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

namespace tessera {

// Whether a line, or the area of a ring whose last point is the first again, and a closed box have a point in common.
bool line_meets(std::span<const Point> line, const Bounds& box);
bool ring_meets(std::span<const Point> ring, const Bounds& box);

// With points between its corners, so that its sides go where those on the ground do; closed.
std::vector<Point> dense_ring(std::span<const Point> corners);

// In which systems features are told, and a box of them is asked for.
struct MapForm {
  bool stored = false, stored_box = false;  // as the result has them; else in longitude and latitude
  bool swapped = false;                     // what is as the result has it is told, and asked for, with y before x
};

// A page of features.
class FeaturePage {
 public:
  // At most `limit` of those that meet `box`, if there is one: x before y, whatever the form.
  FeaturePage(const LonLat& places, const std::optional<Bounds>& box, std::uint64_t limit, MapForm form)
      : places_(places), box_(box), form_(form), limit_(limit) {}

  enum class Kind : bool { ring, line };
  // False: it belongs to the next page, and nothing more is wanted. `points` in the coordinates of the result; `third`:
  // the third coordinate of all, if they have one.
  Result<bool> add(std::uint64_t id, const nlohmann::ordered_json& properties, Kind kind, std::vector<Point> points,
                   std::optional<double> third = {});

  std::uint64_t count() const { return count_; }
  std::uint64_t last() const { return last_; }  // the id of the last one. REQUIRES: there is one
  bool full() const { return full_; }
  // The features, with commas between.
  std::string take() { return std::move(text_); }

 private:
  static constexpr std::uint64_t points_max = 500'000;  // of a page; one feature may have more

  const LonLat& places_;
  std::optional<Bounds> box_;
  MapForm form_;
  std::uint64_t limit_, count_ = 0, points_ = 0, last_ = 0;
  bool full_ = false;
  std::string text_;
};

}  // namespace tessera
