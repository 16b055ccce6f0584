// A cloud in memory, cut into units as files are.
#pragma once

#include <cstdint>
#include <memory>
#include <random>
#include <vector>

#include "src/input/cloud/point_units.h"

namespace tessera::testing_region {

class MemoryUnits : public PointUnits {
 public:
  struct Unit {
    std::vector<LocalPoint> points;
    Bounds bounds;
  };
  explicit MemoryUnits(std::vector<Unit> units);

  const std::vector<PointUnit>& list() const override { return list_; }
  Status read(std::span<const std::size_t> units,
              const std::function<Status(std::size_t, CloudBatch&)>& visit) override;
  std::string name(std::size_t unit) const override { return "unit " + std::to_string(unit); }
  std::uint64_t bytes_read() const override { return bytes_read_; }
  const std::vector<std::size_t>& read_units() const { return read_; }

 private:
  std::vector<Unit> units_;
  std::vector<PointUnit> list_;
  std::vector<std::size_t> read_;
  std::uint64_t bytes_read_ = 0;
};

// As COPC: an octree, in 2D a quadtree, each node of which has up to `node_points` of the points of its cube, drawn at
// random, and its children the others. Bounds are the cubes, which touch each other.
std::unique_ptr<MemoryUnits> octree_units(const std::vector<LocalPoint>& points, int dimension, std::size_t node_points,
                                          std::uint64_t seed);
// As files: runs of source indices, each with the box of its points.
std::unique_ptr<MemoryUnits> file_units(const std::vector<LocalPoint>& points, std::size_t files);

}  // namespace tessera::testing_region
