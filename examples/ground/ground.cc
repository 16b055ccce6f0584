// The ground of an airborne scan as a surface: points of class 2, triangulated by x and y, proved, and written for
// other programs with their heights.
//
//   ground SCAN TARGET      TARGET: ground.ply, ground.gpkg, ...
#include <tessera/tessera.h>

#include <cstdio>
#include <string>

int main(int argc, char** argv) try {
  if (argc != 3) {
    std::fprintf(stderr, "ground SCAN TARGET\n");
    return 2;
  }
  const auto options = tessera::TriangulationOptions().dimension(2).classes({2}).warning(
      [](const std::string& sentence) { std::fprintf(stderr, "ground: warning: %s\n", sentence.c_str()); });
  const auto ground = tessera::triangulate({argv[1]}, options);
  const auto proof = ground.verify();
  const auto note = ground.export_to(argv[2], tessera::ExportRequest().overwrite(true));
  if (!note.empty()) std::fprintf(stderr, "ground: %s\n", note.c_str());
  std::printf("%llu of %llu points, %llu triangles, %zu checks passed\n",
              static_cast<unsigned long long>(ground.vertices()), static_cast<unsigned long long>(ground.points_read()),
              static_cast<unsigned long long>(proof.cells()), proof.checks().size());
  return 0;
} catch (const tessera::Failure& failure) {
  std::fprintf(stderr, "ground: %s\n", failure.what());
  return static_cast<int>(failure.cause());
}
