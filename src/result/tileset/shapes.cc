#include "src/result/tileset/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "src/result/tileset/columns.h"
#include "src/result/tileset/glb_file.h"

namespace tessera::tileset {
namespace {

// For a positively oriented cell, the corners of the facet opposite each corner, seen from outside.
constexpr std::size_t facet_corners[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

// The corners of cells, with the values by which viewers colour.
class Corners {
 public:
  explicit Corners(const query::CellSet& cells)
      : mesh_(cells.mesh.mesh),
        rows_(cells.mesh.rows),
        row_bytes_(row_bytes(cells.mesh.schema)),
        intensity_(find_column(cells.mesh.schema, "intensity")),
        class_(find_column(cells.mesh.schema, "classification")) {}

  std::size_t cells() const { return mesh_.cell_ghost.size(); }
  std::size_t vertex(std::size_t cell, std::size_t k) const {
    return static_cast<std::size_t>(mesh_.cells[4 * cell + k]);
  }
  const Point& at(std::size_t vertex) const { return mesh_.points[vertex]; }
  PointId id(std::size_t vertex) const { return mesh_.ids[vertex]; }
  ShapeVertex shown(std::size_t cell, std::size_t vertex, const Point& at) const {
    const std::byte* row = row_bytes_ == 0 ? nullptr : rows_.data() + vertex * row_bytes_;
    return {at, static_cast<std::uint32_t>(cell), clamped<std::uint16_t>(intensity_.at(row)),
            clamped<std::uint8_t>(class_.at(row))};
  }

 private:
  const TileMesh& mesh_;
  const std::vector<std::byte>& rows_;
  std::size_t row_bytes_;
  Column intensity_, class_;
};

// Where the plane crosses the edge between two vertices, one on each side. The result is the same for each cell with
// the edge, because the computation begins at the vertex with the lower source index.
ShapeVertex between(const Corners& corners, std::size_t cell, std::size_t a, std::size_t b, const query::Plane& plane) {
  if (corners.id(b) < corners.id(a)) std::swap(a, b);
  const Point &from = corners.at(a), &to = corners.at(b);
  const double before = plane.above(from), after = plane.above(to), part = before / (before - after);
  const Point at{std::lerp(from.x, to.x, part), std::lerp(from.y, to.y, part), std::lerp(from.z, to.z, part)};
  return corners.shown(cell, part < 0.5 ? a : b, at);
}

double turn(const ShapeVertex& a, const ShapeVertex& b, const ShapeVertex& c, const Point& n) {
  const double ux = b.at.x - a.at.x, uy = b.at.y - a.at.y, uz = b.at.z - a.at.z;
  const double vx = c.at.x - a.at.x, vy = c.at.y - a.at.y, vz = c.at.z - a.at.z;
  return n.x * (uy * vz - uz * vy) + n.y * (uz * vx - ux * vz) + n.z * (ux * vy - uy * vx);
}

// The intersection of a cell and the plane, in order around it; fewer than three corners mean nothing.
std::vector<ShapeVertex> cut(const Corners& corners, std::size_t cell, const query::Plane& plane) {
  std::array<std::size_t, 4> above{}, below{};
  std::size_t n = 0, m = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    const std::size_t v = corners.vertex(cell, k);
    if (plane.above(corners.at(v)) >= 0)
      above[n++] = v;
    else
      below[m++] = v;
  }
  std::vector<ShapeVertex> ring;
  const auto add = [&](std::size_t i, std::size_t j) {
    const ShapeVertex found = between(corners, cell, above[i], below[j], plane);
    for (const ShapeVertex& other : ring)
      if (other.at == found.at) return;
    ring.push_back(found);
  };
  if (n == 2) {
    add(0, 0);
    add(0, 1);
    add(1, 1);
    add(1, 0);
  } else {
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < m; ++j) add(i, j);
  }
  if (ring.size() >= 3 && turn(ring[0], ring[1], ring[2], plane.normal) < 0) std::reverse(ring.begin(), ring.end());
  return ring;
}

bool apart(const std::vector<ShapeVertex>& ring, const Bounds& box) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto beyond = [&](const auto& is) { return std::all_of(ring.begin(), ring.end(), is); };
    if (beyond([&](const ShapeVertex& v) { return v.at[axis] < box.lo[axis]; }) ||
        beyond([&](const ShapeVertex& v) { return v.at[axis] > box.hi[axis]; }))
      return true;
  }
  return false;
}

}  // namespace

Shape hull_shape(const query::HullCells& hull) {
  const Corners corners(hull.set);
  Shape shape{"hull", {}, {}, hull.lengths};
  for (std::size_t cell = 0; cell < corners.cells(); ++cell)
    for (std::size_t k = 0; k < 4; ++k) {
      if ((hull.facets[cell] >> k & 1u) == 0) continue;
      for (const std::size_t corner : facet_corners[k]) {
        const std::size_t v = corners.vertex(cell, corner);
        shape.corners.push_back(static_cast<std::uint32_t>(shape.vertices.size()));
        shape.vertices.push_back(corners.shown(cell, v, corners.at(v)));
      }
    }
  return shape;
}

Shape section_shape(const query::CellSet& cells, const query::Plane& plane, const Bounds& box) {
  const Corners corners(cells);
  Shape shape{"section", {}, {}};
  for (std::size_t cell = 0; cell < corners.cells(); ++cell) {
    const std::vector<ShapeVertex> ring = cut(corners, cell, plane);
    if (ring.size() < 3 || apart(ring, box)) continue;
    const auto first = static_cast<std::uint32_t>(shape.vertices.size());
    for (std::uint32_t k = 2; k < ring.size(); ++k)
      shape.corners.insert(shape.corners.end(), {first, first + k - 1, first + k});
    shape.vertices.insert(shape.vertices.end(), ring.begin(), ring.end());
  }
  return shape;
}

Shape solids_shape(const query::CellSet& cells, double shrink) {
  const Corners corners(cells);
  Shape shape{"solids", {}, {}};
  for (std::size_t cell = 0; cell < corners.cells(); ++cell) {
    const Point& first = corners.at(corners.vertex(cell, 0));
    Point mean;
    for (int axis = 0; axis < 3; ++axis) {
      for (std::size_t k = 1; k < 4; ++k) mean[axis] += (corners.at(corners.vertex(cell, k))[axis] - first[axis]) / 4;
      mean[axis] += first[axis];
    }
    const auto begin = static_cast<std::uint32_t>(shape.vertices.size());
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t v = corners.vertex(cell, k);
      Point at;
      for (int axis = 0; axis < 3; ++axis) at[axis] = std::lerp(mean[axis], corners.at(v)[axis], shrink);
      shape.vertices.push_back(corners.shown(cell, v, at));
      for (const std::size_t corner : facet_corners[k])
        shape.corners.push_back(begin + static_cast<std::uint32_t>(corner));
    }
  }
  return shape;
}

std::vector<std::byte> to_glb(const Shape& shape, const query::CellSet& cells, const Manifest& manifest) {
  using Json = GlbFile::Json;
  Point origin;
  for (int axis = 0; axis < 3; ++axis)
    origin[axis] = std::round(manifest.bounds.lo[axis] / 2 + manifest.bounds.hi[axis] / 2);
  std::vector<Point> positions;
  std::vector<PackedShort> intensities;
  std::vector<PackedByte> classes;
  std::vector<float> tiles;
  std::vector<std::uint32_t> places;
  std::set<int> seen;
  std::uint16_t brightest = 0;
  std::size_t count = 0;
  for (const ShapeVertex& v : shape.vertices) {
    if (positions.empty() || shape.vertices[positions.size() - 1].of != v.of) ++count;
    positions.push_back(v.at);
    intensities.push_back({v.intensity});
    classes.push_back({v.classification});
    tiles.push_back(static_cast<float>(cells.tiles[v.of].value));  // integers below 2^24
    places.push_back(static_cast<std::uint32_t>(cells.places[v.of]));
    seen.insert(v.classification);
    brightest = std::max(brightest, v.intensity);
  }
  Json attributes = Json::array();
  for (const auto& attribute : manifest.schema) attributes.push_back(attribute.name);
  Json extras{{"kind", shape.kind},
              {"origin", {origin.x, origin.y, origin.z}},
              {"crs", manifest.crs},
              {"cells", count},
              {"tiles", manifest.tiles.size()},
              {"heights", {manifest.bounds.lo.z, manifest.bounds.hi.z}},
              {"intensityMax", brightest},
              {"classes", seen},
              {"attributes", std::move(attributes)}};
  if (!shape.lengths.empty()) extras["edgeLengths"] = shape.lengths;
  GlbFile file;
  if (!shape.vertices.empty()) {
    file.add_positions(positions, origin);
    file.add_shorts("_INTENSITY", intensities);
    file.add_bytes("_CLASSIFICATION", classes);
    file.add_floats("_TILE", tiles);
    file.add_words("_CELL", places);
    file.add_triangles(shape.corners, shape.vertices.size());
  }
  return file.finish(extras);
}

}  // namespace tessera::tileset
