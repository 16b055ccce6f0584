#include "tests/kernel/kernel_testing.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <ostream>
#include <random>
#include <set>
#include <span>

#include "src/geometry/predicates/independent/predicates.h"
#include "src/geometry/reference/clouds.h"

namespace tessera::testing {
namespace {

// The points of the integer box that `keep` wants, shuffled.
std::vector<Point> lattice(
    int nx, int ny, int nz, std::uint64_t seed,
    const std::function<bool(const Point&)>& keep = [](const Point&) { return true; }) {
  std::vector<Point> all, list;
  for (int x = 0; x < nx; ++x) {
    for (int y = 0; y < ny; ++y) {
      for (int z = 0; z < nz; ++z) {
        const Point p{static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)};
        if (keep(p)) all.push_back(p);
      }
    }
  }
  for (const std::size_t i : shuffled(all.size(), seed)) list.push_back(all[i]);
  return list;
}

std::vector<Point> joined(std::vector<Point> first, const std::vector<Point>& rest) {
  first.insert(first.end(), rest.begin(), rest.end());
  return first;
}

std::vector<Point> line(int n) {
  std::vector<Point> list;
  for (const std::size_t i : shuffled(static_cast<std::size_t>(n), 5)) {
    const double t = static_cast<double>(i);
    list.push_back({3 * t, -5 * t, 0});
  }
  return list;
}

std::vector<KernelCloud> for_all_kernels(std::vector<KernelCloud> clouds) {
  const std::size_t n = clouds.size();
  for (std::size_t i = 0; i < n; ++i) {
    clouds.push_back(clouds[i]);
    clouds.back().kind = KernelKind::flat;
  }
  return clouds;
}

std::vector<KernelCloud> make_spanning() {
  std::vector<KernelCloud> clouds;
  for (const int d : {2, 3}) {
    for (const auto& kind : cloud_kinds()) {
      KernelCloud cloud{kind, d, {}, KernelKind::cgal};
      for (const LocalPoint& p : make_cloud(kind, d, 250, 42)) cloud.points.push_back(p.at);
      clouds.push_back(std::move(cloud));
    }
    clouds.push_back(KernelCloud{"line_first", d, joined(line(20), lattice(5, 4, d == 3 ? 3 : 1, 3, [](const Point& p) {
                                                           return p != Point{0, 0, 0};
                                                         }))});
  }
  clouds.push_back(KernelCloud{"square", 2, lattice(2, 2, 1, 1)});
  clouds.push_back(KernelCloud{"grid", 2, lattice(15, 15, 1, 2)});
  clouds.push_back(KernelCloud{"cube", 3, lattice(2, 2, 2, 1)});
  clouds.push_back(KernelCloud{"grid", 3, lattice(6, 6, 6, 2)});
  clouds.push_back(KernelCloud{"sphere_int", 3, lattice(19, 19, 19, 4, [](const Point& p) {
                                 const double x = p.x - 9, y = p.y - 9, z = p.z - 9;
                                 return x * x + y * y + z * z == 81;
                               })});
  clouds.push_back(KernelCloud{
      "plane_first", 3, joined(lattice(8, 8, 1, 6), lattice(4, 4, 3, 7, [](const Point& p) { return p.z > 0; }))});
  clouds.push_back(KernelCloud{"plane_and_one", 3, joined(lattice(9, 9, 1, 8), {{4.25, 4.25, 0x1p-60}})});
  clouds.push_back(KernelCloud{"denormal", 3, {}});
  for (const Point& p : lattice(5, 5, 5, 9)) clouds.back().points.push_back({p.x * 5e-324, p.y * 5e-324, p.z * 5e-324});
  return for_all_kernels(std::move(clouds));
}

std::vector<KernelCloud> make_flat() {
  std::vector<KernelCloud> clouds;
  const std::vector<Point> few{{1, 2, 0}, {4, 2, 0}, {3, 7, 0}};
  for (const int d : {2, 3}) {
    for (std::size_t n = 0; n <= static_cast<std::size_t>(d); ++n) {
      clouds.push_back(
          KernelCloud{"points" + std::to_string(n), d, {few.begin(), few.begin() + static_cast<std::ptrdiff_t>(n)}});
    }
    clouds.push_back(KernelCloud{"line", d, line(50)});
  }
  clouds.push_back(KernelCloud{"plane", 3, lattice(7, 7, 1, 2)});
  std::vector<Point> tilted;
  for (const Point& p : lattice(6, 6, 1, 2)) tilted.push_back({p.x, p.y, 3 * p.x - 5 * p.y + 7});
  clouds.push_back(KernelCloud{"tilted", 3, tilted});
  return for_all_kernels(std::move(clouds));
}

}  // namespace

const std::vector<KernelCloud>& spanning_clouds() {
  static const auto clouds = make_spanning();
  return clouds;
}

const std::vector<KernelCloud>& flat_clouds() {
  static const auto clouds = make_flat();
  return clouds;
}

std::string name_of_cloud(const KernelCloud& cloud) {
  return cloud.name + std::to_string(cloud.dimension) + (cloud.kind == KernelKind::flat ? "_flat" : "");
}

std::ostream& operator<<(std::ostream& out, const KernelCloud& cloud) {
  return out << cloud.points.size() << " points of " << name_of_cloud(cloud);
}

std::vector<IdCell> cells_of(const Kernel& kernel, const std::vector<PointId>& ids) {
  const std::size_t corners = static_cast<std::size_t>(kernel.max_dimension()) + 1;
  const CellList list = kernel.cells();
  std::vector<IdCell> cells;
  for (std::size_t c = 0; c < list.vertices.size(); c += corners) {
    IdCell cell{infinite_id, infinite_id, infinite_id, infinite_id};
    for (std::size_t i = 0; i < corners; ++i) {
      const Vertex v = list.vertices[c + i];
      cell[i] = v == infinite_vertex ? infinite_id : ids.at(v - 1);
    }
    std::sort(cell.begin(), cell.end());
    cells.push_back(cell);
  }
  std::sort(cells.begin(), cells.end());
  return cells;
}

std::vector<IdCell> cells_of(const Kernel& kernel) {
  std::vector<PointId> ids;
  for (std::uint64_t i = 0; i < kernel.vertices(); ++i) ids.push_back({i});
  return cells_of(kernel, ids);
}

std::vector<IdCell> reference(const std::vector<Point>& points, int dimension) {
  std::vector<LocalPoint> labelled;
  for (const Point& p : points) labelled.push_back({p, labelled.size()});
  return global_delaunay_with_hull(labelled, dimension);
}

std::string wrong_with(const Kernel& kernel) {
  const int d = kernel.max_dimension();
  const std::size_t corners = static_cast<std::size_t>(d) + 1;
  const CellList list = kernel.cells();
  const std::size_t cells = list.vertices.size() / corners;
  const auto vertex = [&](std::size_t c, std::size_t i) { return list.vertices[c * corners + i]; };
  const auto orientation = [&](std::span<const Point> p) {
    return d == 3 ? independent::orientation_3(p[0], p[1], p[2], p[3]) : independent::orientation_2(p[0], p[1], p[2]);
  };
  for (std::size_t c = 0; c < cells; ++c) {
    const std::string at = "cell " + std::to_string(c) + ": ";
    std::size_t infinite = corners;
    std::vector<Point> p(corners);
    for (std::size_t i = 0; i < corners; ++i) {
      if (vertex(c, i) == infinite_vertex) {
        infinite = i;
      } else {
        p[i] = kernel.point(vertex(c, i));
      }
    }
    if (infinite == corners && orientation(p) <= 0) return at + "not positively oriented";
    for (std::size_t i = 0; i < corners; ++i) {
      const std::size_t n = list.neighbors[c * corners + i];
      if (n >= cells) return at + "no such neighbour";
      std::multiset<Vertex> mine, others;
      std::size_t back = corners;
      for (std::size_t k = 0; k < corners; ++k) {
        if (k != i) mine.insert(vertex(c, k));
        if (list.neighbors[n * corners + k] == c) back = k;
      }
      if (back == corners) return at + "a neighbour does not know it";
      for (std::size_t k = 0; k < corners; ++k) {
        if (k != back) others.insert(vertex(n, k));
      }
      if (mine != others) return at + "the facets differ";
      const Vertex opposite = vertex(n, back);
      if (opposite == infinite_vertex) continue;
      const Point e = kernel.point(opposite);
      if (infinite == i) {  // the neighbour is inside the hull, where the infinite vertex is not
        auto with = p;
        with[i] = e;
        if (orientation(with) >= 0) return at + "infinite, and its neighbour on the same side";
      }
      if (infinite != corners) continue;
      const int side = d == 3 ? independent::in_sphere_perturbed_3(p[0], p[1], p[2], p[3], e)
                              : independent::in_circle_perturbed_2(p[0], p[1], p[2], e);
      if (side >= 0) return at + "a neighbour's vertex is inside its circumsphere";
    }
  }
  return "";
}

std::unique_ptr<Kernel> built(const KernelCloud& cloud) {
  auto kernel = make_kernel(cloud.dimension, cloud.kind);
  kernel->build(cloud.points);
  return kernel;
}

std::unique_ptr<Kernel> copy_of(const Kernel& kernel, const KernelCloud& cloud) {
  auto copy = make_kernel(cloud.dimension, cloud.kind);
  return copy->load(kernel.save()) ? std::move(copy) : nullptr;
}

std::vector<std::size_t> shuffled(std::size_t n, std::uint64_t seed) {
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), std::mt19937_64(seed));
  return order;
}

}  // namespace tessera::testing
