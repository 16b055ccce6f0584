// Writes a small result for the tests in Python: store_sample_writer FOLDER DIMENSION.
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "tests/store/sample_result.h"

int main(int argc, char** argv) {
  using namespace tessera;
  if (argc < 3) {
    std::fprintf(stderr, "usage: store_sample_writer FOLDER DIMENSION\n");
    return EXIT_FAILURE;
  }
  const std::filesystem::path out = argv[1];
  const int dimension = std::atoi(argv[2]);
  StoreOptions options;
  options.schema = {
      {"intensity", AttributeType::u16}, {"gps_time", AttributeType::f64}, {"50 % of \"<it>\"", AttributeType::u8}};
  auto points = test::sample_points(test::Shape::uniform, dimension, 3000);
  for (int corner = 0; corner < (1 << dimension); ++corner)  // so that the hull's volume is known: 1
    points.push_back(
        {static_cast<double>(corner & 1), static_cast<double>(corner >> 1 & 1), static_cast<double>(corner >> 2 & 1)});
  const auto meshes = test::sample_tiles(points, dimension, 5);
  test::store_sample(out, meshes, options);
  return EXIT_SUCCESS;
}
