#include "src/result/voronoi/polyhedron.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace tessera::voronoi {

namespace {

bool place_before(const Point& a, const Point& b) {
  if (a.x != b.x) return a.x < b.x;
  return a.y != b.y ? a.y < b.y : a.z < b.z;
}
bool same_place(const Point& a, const Point& b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

using Vector = std::array<long double, 3>;

Vector from_to(const Point& from, const Point& to) {
  return {static_cast<long double>(to.x) - from.x, static_cast<long double>(to.y) - from.y,
          static_cast<long double>(to.z) - from.z};
}
Vector turn(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

}  // namespace

// Each face is cut into triangles from its first corner, and each triangle makes a tetrahedron with the cell's first
// corner.
PolyhedronMeasures measure(const Polyhedron& cell) {
  const Point& origin = cell.corners.front();
  long double six = 0, twice = 0;
  Vector moment{};
  for (const auto& face : cell.faces) {
    const Vector a = from_to(origin, cell.corners[face[0]]);
    for (std::size_t i = 1; i + 1 < face.size(); ++i) {
      const Point &p = cell.corners[face[i]], &q = cell.corners[face[i + 1]];
      const Vector b = from_to(origin, p), c = from_to(origin, q), bc = turn(b, c);
      const long double part = a[0] * bc[0] + a[1] * bc[1] + a[2] * bc[2];
      six += part;
      for (std::size_t k = 0; k < 3; ++k) moment[k] += part * (a[k] + b[k] + c[k]);
      const Vector normal = turn(from_to(cell.corners[face[0]], p), from_to(cell.corners[face[0]], q));
      twice += std::sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    }
  }
  PolyhedronMeasures measures{static_cast<double>(six / 6), static_cast<double>(twice / 2), {}};
  for (int axis = 0; axis < 3; ++axis)
    measures.centroid[axis] = static_cast<double>(origin[axis] + moment[static_cast<std::size_t>(axis)] / (4 * six));
  return measures;
}

void PolyhedronMaker::clear() { faces_.clear(); }

void PolyhedronMaker::add_face(std::span<const Point> corners) {
  std::vector<Point> face(corners.begin(), corners.end());
  face.erase(std::unique(face.begin(), face.end(), same_place), face.end());
  while (face.size() > 1 && same_place(face.front(), face.back())) face.pop_back();
  if (face.size() < 3) return;
  std::rotate(face.begin(), std::min_element(face.begin(), face.end(), place_before), face.end());
  faces_.push_back(std::move(face));
}

bool PolyhedronMaker::finish(Polyhedron& cell) {
  cell.corners.clear();
  cell.faces.clear();
  if (faces_.size() < 4) return false;
  for (const auto& face : faces_) cell.corners.insert(cell.corners.end(), face.begin(), face.end());
  std::sort(cell.corners.begin(), cell.corners.end(), place_before);
  cell.corners.erase(std::unique(cell.corners.begin(), cell.corners.end(), same_place), cell.corners.end());
  for (const auto& face : faces_) {
    auto& numbers = cell.faces.emplace_back();
    for (const Point& p : face)
      numbers.push_back(static_cast<std::uint32_t>(
          std::lower_bound(cell.corners.begin(), cell.corners.end(), p, place_before) - cell.corners.begin()));
  }
  return true;
}

std::vector<std::byte> packed(const Polyhedron& cell) {
  std::vector<std::byte> bytes;
  const auto put = [&](const auto& value) {
    const auto more = std::as_bytes(std::span(&value, 1));
    bytes.insert(bytes.end(), more.begin(), more.end());
  };
  put(std::uint64_t{cell.corners.size()});
  for (const Point& p : cell.corners) put(p);
  put(std::uint64_t{cell.faces.size()});
  for (const auto& face : cell.faces) {
    put(std::uint64_t{face.size()});
    for (const std::uint32_t corner : face) put(std::uint64_t{corner});
  }
  return bytes;
}

Polyhedron unpacked(std::span<const std::byte> bytes) {
  Polyhedron cell;
  const std::byte* at = bytes.data();
  const auto number = [&] {
    std::uint64_t value = 0;
    std::memcpy(&value, at, sizeof value);
    at += sizeof value;
    return value;
  };
  cell.corners.resize(number());
  std::memcpy(cell.corners.data(), at, cell.corners.size() * sizeof(Point));
  at += cell.corners.size() * sizeof(Point);
  cell.faces.resize(number());
  for (auto& face : cell.faces) {
    face.resize(number());
    for (std::uint32_t& corner : face) corner = static_cast<std::uint32_t>(number());
  }
  return cell;
}

}  // namespace tessera::voronoi
