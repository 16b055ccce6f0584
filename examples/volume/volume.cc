// The volume (in 2D: the area) of the convex hull of a point cloud, summed over the simplices of its Delaunay
// triangulation, tile by tile: only one tile is in memory at a time.
//
//   volume [FILE...]      LAS, LAZ, PLY, OBJ, text, NumPy, ...
//   volume                a million random points in the unit cube
#include <tessera/tessera.h>

#include <array>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

namespace {

using Vector = std::array<double, 3>;

Vector difference(const double* to, const double* from) { return {to[0] - from[0], to[1] - from[1], to[2] - from[2]}; }

double determinant(const Vector& a, const Vector& b, const Vector& c) {
  return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
}

// Of one simplex: `corners` are indices of points, whose z is 0 in 2D.
double measure(std::span<const double> points, std::span<const std::int32_t> corners) {
  const auto at = [&](std::size_t i) { return &points[3 * static_cast<std::size_t>(corners[i])]; };
  const Vector a = difference(at(1), at(0)), b = difference(at(2), at(0));
  if (corners.size() == 3) return (a[0] * b[1] - a[1] * b[0]) / 2;
  return determinant(a, b, difference(at(3), at(0))) / 6;
}

double measure(const tessera::Tile& tile) {
  const auto corners = static_cast<std::size_t>(tile.dimension()) + 1;
  double sum = 0;
  for (std::size_t c = 0; c < tile.ghost().size(); ++c) {
    // A cell that several tiles share is main in one of them: there it counts.
    if (tile.ghost()[c] == 0) sum += measure(tile.points(), tile.cells().subspan(c * corners, corners));
  }
  return sum;
}

std::vector<double> random_points(std::size_t n) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> coordinate(0, 1);
  std::vector<double> points(3 * n);
  for (double& x : points) x = coordinate(random);
  return points;
}

void show(const tessera::JobProgress& now) {
  std::fprintf(stderr, "\r%-14s %5.1f s  %llu of %llu points triangulated ", now.phase.c_str(), now.seconds,
               static_cast<unsigned long long>(now.points_triangulated),
               static_cast<unsigned long long>(now.points_total));
  if (now.phase == "done") std::fputc('\n', stderr);
}

}  // namespace

int main(int argc, char** argv) try {
  tessera::TriangulationOptions options;
  options.progress(show);
  const std::vector<std::string> files(argv + 1, argv + argc);
  if (!files.empty()) options.dimension(0);  // as the files have it
  const auto triangulation =
      files.empty() ? tessera::triangulate(random_points(1'000'000), options) : tessera::triangulate(files, options);
  double sum = 0;
  for (std::size_t i = 0; i < triangulation.tiles(); ++i) sum += measure(triangulation.tile(i));
  std::printf("%llu points, %llu cells in %zu tiles, %s %.17g\n",
              static_cast<unsigned long long>(triangulation.points_read()),
              static_cast<unsigned long long>(triangulation.cells()), triangulation.tiles(),
              triangulation.dimension() == 3 ? "volume" : "area", sum);
  return 0;
} catch (const tessera::Failure& failure) {
  std::fprintf(stderr, "volume: %s\n", failure.what());
  return static_cast<int>(failure.cause());
}
