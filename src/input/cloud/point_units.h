// A cloud that can be read in parts, each with the box in which its points are.
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
  std::uint64_t points = 0;  // at most: filters may leave fewer
  std::uint64_t bytes = 0;   // that reading it takes
  Bounds bounds;             // closed, of all its points; in 2D without z
};

class PointUnits {
 public:
  virtual ~PointUnits() = default;
  // Together they have every point, each once. Source indices are those of the whole cloud.
  virtual const std::vector<PointUnit>& list() const = 0;
  // Reads these units, and gives `visit` their points with the unit's number; it may stop by returning an error. An
  // error, too, when a point is not in its unit's bounds: what is not read rests on them.
  virtual Status read(std::span<const std::size_t> units,
                      const std::function<Status(std::size_t unit, CloudBatch& batch)>& visit) = 0;
  // What people are told of a unit: its file, where in it, and its bounds.
  virtual std::string name(std::size_t unit) const = 0;
  // Bytes that were read so far.
  virtual std::uint64_t bytes_read() const = 0;
};

}  // namespace tessera
