// A smooth surface for contour lines on maps: means of the surface of a 2D result at the nodes of a lattice.
//
// A node's value is the mean of 64 samples, 8 x 8 at distances of a quarter of the lattice's width. A sample has less
// weight the farther it is: 7/8, 5/8, 3/8 and 1/8 in x, and likewise in y. A sample counts only together with the
// opposite one, so that a slope stays the same at the border. A node has no value when less than half of the weight is
// there.
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

// What must be drawn for the lines in the squares that meet a box.
struct SmoothPlan {
  Lattice whole;  // all squares in which the result may have lines
  Lattice nodes;  // those squares that meet the box
  Grid samples;   // the samples for these nodes
  Bounds around;  // where the samples are
};

// `box`, extended on all sides by a square and by the reach of its nodes. `res` is the distance between nodes.
Bounds around(const Bounds& box, double res);

// REQUIRES: options.smooth has a value. Errors: usage when it is not a length or too small; memory beyond
// options.samples_max.
Result<SmoothPlan> plan_smooth(const ContourOptions& options, const Bounds& vertices);

// Computes the values of nodes, in units of the interval from the base, so that levels are whole numbers. A value is
// rounded to a millionth (2^-20) of the interval, and half of that is added. So no value is a level, and ground at a
// level is above it. The values depend only on the samples, not on `part`. NaN: there is no value. Errors: those of
// `samples`.
class SmoothSurface {
 public:
  // References must stay valid as long as this object.
  SmoothSurface(const SampleFile& samples, const Levels& levels) : samples_(samples), levels_(levels) {}
  Status read(const Lattice& part, std::vector<double>& values);

 private:
  const SampleFile& samples_;
  Levels levels_;
  std::vector<double> window_;
};

// Divides the lattice into parts of at most part_squares squares a side. Each square is in one part.
inline constexpr std::int64_t part_squares = 256;
std::vector<Lattice> parts_of(const Lattice& nodes);

}  // namespace tessera::terrain
