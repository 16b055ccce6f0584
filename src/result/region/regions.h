// The exact cells of a region of a cloud that is too large to be triangulated, or not worth it.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/duplicate_policy.h"
#include "src/base/point.h"
#include "src/base/result.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "src/input/cloud/point_units.h"
#include "src/result/region/region_shape.h"
#include "src/result/region/unit_tree.h"

namespace tessera {

// What was read of a unit.
struct LoadedUnit {
  std::vector<LocalPoint> points;
  std::vector<std::byte> rows;
  std::chrono::steady_clock::time_point used = {};  // the last time
  std::uint64_t bytes() const { return points.size() * sizeof(LocalPoint) + rows.size(); }
};

struct RegionLimits {
  std::uint64_t max_points = std::numeric_limits<std::uint64_t>::max();  // of the units that are triangulated
  double max_seconds = std::numeric_limits<double>::infinity();          // looked at between units and rounds
  std::uint64_t memory_bytes = std::numeric_limits<std::uint64_t>::max();
  bool partial = false;  // beyond them give what there is, instead of an error
  // Is told how many points were read, and how many are needed, which may become more; or null.
  std::function<void(std::uint64_t points, std::uint64_t needed)> progress = {};
};

struct RegionFigures {
  std::uint64_t units = 0, points = 0, bytes = 0;                 // of the whole cloud
  std::uint64_t units_used = 0, points_used = 0;                  // that were triangulated
  std::uint64_t units_read = 0, points_read = 0, bytes_read = 0;  // for this question
  std::uint64_t rounds = 0;
  double seconds = 0;
};

// The cells that meet a region, as those of one tile that owns all vertices.
struct RegionCells {
  TileMesh mesh;
  std::vector<std::byte> rows;      // of the vertices
  std::vector<std::uint8_t> final;  // by cell: 1, it is a cell of the whole triangulation
  bool complete = true;             // all cells are final, and together all that meet the region
  std::string needed;               // else: what is still needed, as a sentence
  RegionFigures figures;
};

// What equal points of a cloud have to do with each other.
struct EqualPoints {
  DuplicatePolicy keep = DuplicatePolicy::first;
  std::optional<std::size_t> height_at = {};  // where a row has the height, when points are kept by it
};

// Questions to one cloud. What was read for one is there for the next, until forget(). Not thread-safe.
class Regions {
 public:
  // `row_bytes`: of a point's attributes, as the units give them.
  Regions(std::unique_ptr<PointUnits> units, int dimension, std::size_t row_bytes, EqualPoints equal = {});

  // The cells of the cloud's Delaunay triangulation that have a point in common with the closed box `region`: exactly
  // those that triangulating the whole cloud gives, source indices included, if the points that are not read are where
  // the units say (docs/regions.md). Errors: those of reading; bad_input when all points lie in one hyperplane; memory,
  // naming what is still needed, when a limit does not suffice and `partial` is not wanted, or nothing could be read;
  // interrupted.
  // `shape`: of the region in that box, if it is not all of it.
  Result<RegionCells> ask(const Box& region, const RegionLimits& limits, const std::stop_token& stop = {},
                          const RegionShape& shape = {});

  const PointUnits& units() const { return *units_; }
  const Bounds& bounds() const { return bounds_; }  // of all units
  // Bytes of what was read, and is there for the next question.
  std::uint64_t loaded_bytes() const;
  // Gives back the memory of what was read: of that which was used longest ago, until no more is left than that.
  void forget(std::uint64_t bytes_max = 0);

 private:
  Result<RegionCells> ask_within(const Bounds& region, const RegionShape& shape, const RegionLimits& limits,
                                 const std::stop_token& stop);

  std::unique_ptr<PointUnits> units_;
  int dimension_;
  std::size_t row_bytes_;
  EqualPoints equal_;
  Bounds bounds_;  // of all units
  UnitTree tree_;
  std::map<std::size_t, LoadedUnit> loaded_;  // by unit
  std::uint64_t bytes_told_ = 0;              // that were read for earlier questions
};

}  // namespace tessera
