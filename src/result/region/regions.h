// Finds the exact cells of a region of a cloud that is too large to be triangulated as a whole.
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

// The points of a unit that was read.
struct LoadedUnit {
  std::vector<LocalPoint> points;
  std::vector<std::byte> rows;
  std::chrono::steady_clock::time_point used = {};  // when a question last used the unit
  std::uint64_t bytes() const { return points.size() * sizeof(LocalPoint) + rows.size(); }
};

struct RegionLimits {
  std::uint64_t max_points = std::numeric_limits<std::uint64_t>::max();  // of the units that are triangulated
  double max_seconds = std::numeric_limits<double>::infinity();          // checked between units and between rounds
  std::uint64_t memory_bytes = std::numeric_limits<std::uint64_t>::max();
  bool partial = false;  // when a limit is reached, return the cells found so far instead of an error
  // Called with the points that were read and the points that are needed, a number that may grow; may be null.
  std::function<void(std::uint64_t points, std::uint64_t needed)> progress = {};
};

struct RegionFigures {
  std::uint64_t units = 0, points = 0, bytes = 0;                 // of the whole cloud
  std::uint64_t units_used = 0, points_used = 0;                  // that were triangulated
  std::uint64_t units_read = 0, points_read = 0, bytes_read = 0;  // for this question
  std::uint64_t rounds = 0;
  double seconds = 0;
};

// The cells that meet a region, as the cells of one tile that owns all vertices.
struct RegionCells {
  TileMesh mesh;
  std::vector<std::byte> rows;      // of the vertices
  std::vector<std::uint8_t> final;  // by cell: 1 for a cell of the whole triangulation
  bool complete = true;             // all cells are final, and no cell that meets the region is missing
  std::string needed;               // otherwise: what is still needed, as a sentence
  RegionFigures figures;
};

// How points with equal coordinates become one vertex.
struct EqualPoints {
  DuplicatePolicy keep = DuplicatePolicy::first;
  std::optional<std::size_t> height_at = {};  // offset of the height in a row, when points are kept by height
};

// Answers questions to one cloud. Units that were read for a question are kept for the next ones, until forget(). Not
// thread-safe.
class Regions {
 public:
  // `row_bytes` is the size of a point's attributes as the units return them.
  Regions(std::unique_ptr<PointUnits> units, int dimension, std::size_t row_bytes, EqualPoints equal = {});

  // Returns the cells of the cloud's Delaunay triangulation that have a point in common with the closed box `region`.
  // These are exactly the cells that a triangulation of the whole cloud has, source indices included, if the unread
  // points are where the units say (docs/regions.md). `shape` selects a part of the box as the region. Errors: those of
  // reading; bad_input when all points lie in one hyperplane; memory, with what is still needed, when a limit is too
  // low and `partial` is not set, or when nothing could be read; interrupted.
  Result<RegionCells> ask(const Box& region, const RegionLimits& limits, const std::stop_token& stop = {},
                          const RegionShape& shape = {});

  const PointUnits& units() const { return *units_; }
  const Bounds& bounds() const { return bounds_; }  // of all units
  // Bytes of the units that are kept for the next question.
  std::uint64_t loaded_bytes() const;
  // Frees the memory of kept units, the least recently used first, until at most `bytes_max` bytes are left.
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
