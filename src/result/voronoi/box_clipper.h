// Clips a Voronoi cell of space to a box. Exact: a corner is where three planes meet, and is rounded once.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "src/base/point.h"
#include "src/result/voronoi/exact_number.h"
#include "src/result/voronoi/polyhedron.h"

namespace tessera::voronoi {

// For one thread.
class BoxClipper {
 public:
  // REQUIRES: the box is finite and not flat.
  explicit BoxClipper(const Bounds& box) : box_(box) {}

  // Adds to `maker` the faces of what is left of the cell: of all places in the box that are nearer to `site` than to
  // each of `around`. Faces come in the order of `around`, then those of the box. False when nothing is left.
  bool clip(const Point& site, std::span<const Point> around, PolyhedronMaker& maker);

 private:
  struct Plane {  // a x + b y + c z - d w is positive on the side of the cell
    Whole a, b, c, d;
  };
  struct Corner {  // (x / w, y / w, z / w) times 2^exponent_, with w > 0
    Whole x, y, z, w;
  };
  struct Face {
    std::size_t plane = 0;
    std::vector<std::size_t> ring;
  };
  // A side of a face, in the direction of its ring.
  struct Side {
    std::size_t from = 0, to = 0, face = 0;
    friend auto operator<=>(const Side&, const Side&) = default;
  };

  void begin(const Point& site, std::span<const Point> around);
  Corner meet(std::size_t p, std::size_t q, std::size_t r) const;
  int side(const Plane& plane, const Corner& corner) const;
  bool cut(std::size_t plane);
  void cut_faces(std::size_t plane, std::span<const int> sides);
  void close(std::size_t plane);
  std::vector<Side> sides() const;
  std::size_t corner_on(std::size_t a, std::size_t b, std::size_t face, std::size_t plane, std::span<const Side> all);

  Bounds box_;
  int exponent_ = 0;
  std::vector<Plane> planes_;  // six of the box, then one for each point around
  std::vector<Corner> corners_;
  std::vector<Face> faces_;
  std::vector<std::pair<std::array<std::size_t, 2>, std::size_t>> made_;  // corners on sides that a plane cuts
};

}  // namespace tessera::voronoi
