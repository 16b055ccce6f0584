// A cloud that can be read in units. The points of each unit are in a box.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/input/cloud/cloud.h"

namespace tessera {

struct PointUnit {
  std::uint64_t points = 0;  // at most; filters may leave fewer
  std::uint64_t bytes = 0;   // the bytes that are read for the unit
  Bounds bounds;             // a closed box around all points of the unit; in 2D without z
};

// The units of a cloud, however they are stored.
class PointUnits {
 public:
  virtual ~PointUnits() = default;
  // All units. Each point of the cloud is in one unit. Source indices are those of the whole cloud.
  virtual const std::vector<PointUnit>& list() const = 0;
  // Reads units and calls `visit` with their points and the unit's number. `visit` may stop by returning an error. A
  // point outside its unit's bounds is an error, because code decides by the bounds what it need not read.
  virtual Status read(std::span<const std::size_t> units,
                      const std::function<Status(std::size_t unit, CloudBatch& batch)>& visit) = 0;
  // A description of a unit for people: its file, where in the file, and its bounds.
  virtual std::string name(std::size_t unit) const = 0;
  // The bytes that were read so far.
  virtual std::uint64_t bytes_read() const = 0;
};

}  // namespace tessera
