// Clouds for a kernel, and its cells as sets that can be compared.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <memory>
#include <string>
#include <vector>

#include "src/geometry/kernel/kernel.h"
#include "src/geometry/reference/reference.h"

namespace tessera::testing {

struct KernelCloud {
  std::string name;
  int dimension = 3;
  std::vector<Point> points;  // distinct
  KernelKind kind = KernelKind::cgal;
};

// Each for every kernel: random kinds, whole lattices, and sets that begin flat: coplanar or collinear points first,
// then others.
const std::vector<KernelCloud>& spanning_clouds();
// 0 to d points, collinear and coplanar ones.
const std::vector<KernelCloud>& flat_clouds();

std::string name_of_cloud(const KernelCloud& cloud);
std::ostream& operator<<(std::ostream& out, const KernelCloud& cloud);

// Cells as sorted ids, infinite ones too; ids[v - 1] is the id of vertex v.
std::vector<IdCell> cells_of(const Kernel& kernel, const std::vector<PointId>& ids);
// The same by vertex number minus 1.
std::vector<IdCell> cells_of(const Kernel& kernel);

// CGAL's answer, infinite cells too; ids by rank.
std::vector<IdCell> reference(const std::vector<Point>& points, int dimension);

// "" or what is wrong: finite cells positively oriented, infinite ones as if the infinite vertex stood outside,
// neighbours mutual across the same facet, and no vertex opposite a facet inside the circumsphere of the other cell.
std::string wrong_with(const Kernel& kernel);

std::unique_ptr<Kernel> built(const KernelCloud& cloud);
std::unique_ptr<Kernel> copy_of(const Kernel& kernel, const KernelCloud& cloud);

// 0..n-1 shuffled.
std::vector<std::size_t> shuffled(std::size_t n, std::uint64_t seed);

}  // namespace tessera::testing
