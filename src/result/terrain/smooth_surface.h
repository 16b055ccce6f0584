// A smooth surface for contour lines on maps: means of the surface of a 2D result at the nodes of a lattice.
//
// A node's value is the mean of 64 samples, 8 x 8 at distances of a quarter of the lattice's, each of less weight the
// farther it is: 7/8, 5/8, 3/8, 1/8 of that of the node's own place in x, and so in y. A sample counts together with
// the one opposite of it, so that a slope is no other at the border; a node where less than half of the weight is there
// has no value.
#pragma once

#include <cstdint>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/terrain/contours.h"
#include "src/result/terrain/levels.h"
#include "src/result/terrain/sample_file.h"
#include "src/result/terrain/square_cells.h"

namespace tessera::terrain {

// What is drawn for the lines in the squares that meet a box.
struct SmoothPlan {
  Lattice whole;  // of all squares that the result may have lines in
  Lattice nodes;  // of those squares that meet the box
  Grid samples;   // of which these nodes are means
  Bounds around;  // where those are
};

// `box` with a square and what its nodes reach on all sides. `res`: between nodes.
Bounds around(const Bounds& box, double res);

// REQUIRES: options.smooth. Errors: usage when it is no length, or too small; memory beyond options.samples_max.
Result<SmoothPlan> plan_smooth(const ContourOptions& options, const Bounds& vertices);

// The values of the plan's nodes that are in `part`, in units of the interval from the base, so that levels are whole
// numbers: rounded to a millionth (2^-20) of it, and half of that added, so that no value is a level, and ground at a
// level is above it. A function of the samples, whatever `part` is. NaN: there is none. Errors: of `samples`.
class SmoothSurface {
 public:
  // What is given by reference is there as long as this object.
  SmoothSurface(const SampleFile& samples, const Levels& levels) : samples_(samples), levels_(levels) {}
  Status read(const Lattice& part, std::vector<double>& values);

 private:
  const SampleFile& samples_;
  Levels levels_;
  std::vector<double> window_;
};

// Parts of the lattice that have each of its squares once, of so many squares a side at most.
inline constexpr std::int64_t part_squares = 256;
std::vector<Lattice> parts_of(const Lattice& nodes);

}  // namespace tessera::terrain
