// Answers one question to a cloud, in rounds of reading, triangulating and judging.
#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "src/result/region/growing.h"
#include "src/result/region/judge.h"
#include "src/result/region/region_shape.h"
#include "src/result/region/regions.h"

namespace tessera {

class RegionQuestion {
 public:
  // Units that are read are added to `loaded`. REQUIRES: the region lies within the bounds of all units and is not
  // empty; tree.begin(region) was called.
  RegionQuestion(PointUnits& units, std::map<std::size_t, LoadedUnit>& loaded, UnitTree& tree, int dimension,
                 std::size_t row_bytes, EqualPoints equal, const Bounds& region, RegionShape shape,
                 const RegionLimits& limits, std::stop_token stop);

  Result<RegionCells> answer();

 private:
  struct Wanted {
    std::vector<std::size_t> units;  // that fit into the limits
    std::string beyond;              // the limit that excludes the other units; empty if there are no others
  };

  std::vector<std::size_t> first_units() const;
  bool meets_region(const Bounds& unit) const;
  std::vector<std::size_t> nearest_units(std::size_t n) const;
  Wanted within_limits(std::vector<std::size_t> units) const;
  bool late() const;
  // Loads the units and adds their points. Units that could not be read in time are left out.
  Status add(Wanted& wanted);
  Status load(std::vector<std::size_t>& units, std::string& beyond);
  void add_heights(const LoadedUnit& unit, std::vector<double>& heights) const;
  std::string needed(const std::string& beyond, const std::vector<std::size_t>& units) const;
  RegionCells finished(const CellList& cells, const Judgement& judgement);
  std::vector<std::byte> rows_of(const std::vector<PointId>& ids) const;

  PointUnits& units_;
  std::map<std::size_t, LoadedUnit>& loaded_;
  UnitTree& tree_;
  std::size_t row_bytes_;
  std::optional<std::size_t> height_at_;
  Bounds region_;
  RegionShape shape_;
  RegionLimits limits_;
  std::stop_token stop_;
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  GrowingTriangulation triangulation_;
  std::vector<std::size_t> used_;
  RegionFigures figures_;
};

}  // namespace tessera
