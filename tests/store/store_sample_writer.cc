// Writes a small result for the tests in Python: store_sample_writer FOLDER DIMENSION. With a third argument, also
// exports it to every format its dimension allows, into FOLDER/export.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "src/store/export.h"
#include "tests/store/sample_result.h"

int main(int argc, char** argv) {
  using namespace tessera;
  if (argc < 3) {
    std::fprintf(stderr, "usage: store_sample_writer FOLDER DIMENSION [export]\n");
    return EXIT_FAILURE;
  }
  const std::filesystem::path out = argv[1];
  const int dimension = std::atoi(argv[2]);
  StoreOptions options;
  options.schema = {{"intensity", AttributeType::u16}, {"gps_time", AttributeType::f64}};
  auto points = test::sample_points(test::Shape::uniform, dimension, 3000);
  for (int corner = 0; corner < (1 << dimension); ++corner)  // so that the hull's volume is known: 1
    points.push_back(
        {static_cast<double>(corner & 1), static_cast<double>(corner >> 1 & 1), static_cast<double>(corner >> 2 & 1)});
  const auto meshes = test::sample_tiles(points, dimension, 5);
  test::store_sample(out, meshes, options);
  if (argc == 3) return EXIT_SUCCESS;

  std::filesystem::create_directories(out / "export");
  for (const std::string name : {"ply", "off", "vtu", "parts", "geojson"}) {
    if (name == "geojson" && dimension == 3) continue;
    const auto format = parse_export_format(name == "parts" ? "vtu" : name).value();
    const auto target = out / "export" / (name == "parts" ? "parts" : "mesh." + name);
    const auto result = export_result(out, format, target, {});
    if (!result) {
      std::fprintf(stderr, "%s\n", result.error().where.c_str());
      return EXIT_FAILURE;
    }
  }
  return EXIT_SUCCESS;
}
