// A cell of space with rounded corners, and how a record holds it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "src/base/point.h"

namespace tessera::voronoi {

// Faces run counterclockwise, seen from outside.
struct Polyhedron {
  std::vector<Point> corners;
  std::vector<std::vector<std::uint32_t>> faces;
};

struct PolyhedronMeasures {
  double volume = 0, surface = 0;
  Point centroid{};
};
// The last bits depend on the order of faces and corners.
PolyhedronMeasures measure(const Polyhedron& cell);

// Makes a polyhedron from faces given by their corners. Equal corners become one; faces of fewer than three corners are
// left out.
class PolyhedronMaker {
 public:
  void clear();
  void add_face(std::span<const Point> corners);
  // Numbers the corners in the order of their coordinates. False when fewer than four faces are left: the cell is
  // thinner than doubles resolve.
  bool finish(Polyhedron& cell);

 private:
  std::vector<std::vector<Point>> faces_;
};

// As numbers of 64 bits: the corners' number, their coordinates, the faces' number, and each face as its number of
// corners and their indices.
std::vector<std::byte> packed(const Polyhedron& cell);
Polyhedron unpacked(std::span<const std::byte> bytes);

}  // namespace tessera::voronoi
