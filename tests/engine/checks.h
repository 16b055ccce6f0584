// What must hold of a result folder, checked against CGAL's triangulation of all points.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "src/base/point.h"
#include "src/geometry/reference/reference.h"
#include "tests/engine/engine_run.h"

namespace tessera::testing {

// The right answer for a cloud.
struct Expected {
  std::vector<LocalPoint> points;         // by id; all that were read
  std::uint64_t invalid = 0;              // of them not finite
  std::uint64_t vertices = 0;             // distinct finite ones
  std::vector<DuplicatePair> duplicates;  // (duplicate, kept), ascending
  std::vector<IdCell> cells;              // finite, sorted; empty: no triangulation
  std::vector<IdCell> hull;               // infinite ones, sorted
};
Expected expected_of(std::vector<LocalPoint> points, int dimension);

// "" or what is wrong: the counts, the set of main cells, every tile file (orientation, ghost flags, neighbours, that
// it holds exactly the cells around its own vertices), and verify().
std::string wrong_with(const EngineRun& run, const std::filesystem::path& out, const Expected& expected);

}  // namespace tessera::testing
