// Small results of every kind, and the right answers to questions about them by CGAL and by looking at every cell.
#pragma once

#include <cstddef>
#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/geometry/reference/reference.h"
#include "src/result/query/stored_triangulation.h"
#include "tests/store/sample_result.h"

namespace tessera::test {

enum class Tiles { slabs, random };  // tiles along x, or with points from everywhere

struct SampleKind {
  std::string cloud;  // one of cloud_kinds()
  int dimension = 3;
  Tiles tiles = Tiles::slabs;
  std::uint32_t number = 1;
  bool neighbors = true;
  friend std::ostream& operator<<(std::ostream& out, const SampleKind& kind) {
    return out << kind.cloud << "_" << kind.dimension << "d_" << kind.number
               << (kind.tiles == Tiles::slabs ? "_slabs" : "_random") << (kind.neighbors ? "" : "_alone");
  }
};
// Every cloud of cloud_kinds() in 2D and 3D, in one tile and many.
std::vector<SampleKind> sample_kinds();

// Vertices have the attribute "plane" (f64): plane_at(), and "wave" (f32), which is not linear.
double plane_at(const Point& p);
float wave_at(const Point& p);

class QuerySample {
 public:
  explicit QuerySample(const SampleKind& kind, std::size_t n = 150);

  const std::filesystem::path& out() const { return folder_.path(); }
  const std::vector<Point>& points() const { return points_; }  // by source index
  int dimension() const { return dimension_; }
  const std::vector<IdCell>& cells() const { return cells_; }  // CGAL's

  // The cell that locate() is to give, or none; CGAL's predicates on CGAL's cells.
  const IdCell* right_cell(const Point& q) const;
  // By the sample's tiles.
  TileId owner(PointId id) const { return owners_[id.value]; }
  // Points of every kind: anywhere in and around the cloud, vertices, on edges and facets as far as doubles have them,
  // beside vertices, in the planes of facets.
  std::vector<Point> questions(std::size_t n, unsigned seed) const;

  query::StoredTriangulation open(std::uint64_t memory_bytes = std::uint64_t{1} << 30) const;

 private:
  TemporaryFolder folder_;
  int dimension_;
  std::vector<Point> points_;
  std::vector<TileId> owners_;
  std::vector<IdCell> cells_;
};

IdCell ids_of(const query::Cell& cell);

}  // namespace tessera::test
