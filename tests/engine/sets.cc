#include "tests/engine/sets.h"

#include <algorithm>
#include <bit>
#include <fstream>
#include <memory>
#include <set>
#include <utility>

#include "src/input/reader.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;
static_assert(std::endian::native == std::endian::little);

// gen.py writes planar sets as .bin too: these are its names.
bool planar(const std::string& name) {
  static const std::set<std::string> names{"grid2", "circle2_int", "uniform2", "collinear2"};
  return names.contains(name);
}

bool raw_doubles(const CloudSet& set) { return set.source.extension() == ".bin" || set.source.extension() == ".bin2"; }

Result<std::vector<double>> read_doubles(const fs::path& path) {
  std::vector<double> values(fs::file_size(path) / sizeof(double));
  std::ifstream file(path, std::ios::binary);
  file.read(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(values.size() * sizeof(double)));
  if (!file) return error(Errc::io, path.string() + ": cannot be read");
  return values;
}

}  // namespace

std::vector<CloudSet> cloud_sets(const fs::path& generated, const std::vector<fs::path>& real) {
  std::vector<CloudSet> sets;
  const auto add = [&](const fs::path& path, bool made) {
    CloudSet set;
    set.name = made ? path.stem().string() : path.filename().string();
    set.source = path;
    set.generated = made;
    set.stored_dimension = (made && planar(set.name)) || path.extension() == ".bin2" ? 2 : 3;
    if (set.stored_dimension == 3) set.dimensions.push_back(3);
    set.dimensions.push_back(2);
    set.weight = fs::file_size(path);
    if (path.extension() == ".las") set.weight = set.weight * 24 / 30;
    sets.push_back(std::move(set));
  };
  for (const auto& file : fs::directory_iterator(generated)) {
    if (file.path().extension() == ".bin") add(file.path(), true);
  }
  std::set<std::string> names;
  for (const fs::path& folder : real) {
    if (!fs::is_directory(folder)) continue;
    for (const auto& file : fs::recursive_directory_iterator(folder)) {
      const fs::path& path = file.path();
      const auto has_twin = [&](const char* extension) {
        return fs::exists(fs::path(path).replace_extension(extension));
      };
      static const std::set<std::string> kinds{".las", ".ply", ".xyz", ".csv", ".bin", ".bin2"};
      if (!kinds.contains(path.extension())) continue;
      if (path.extension() == ".bin" && has_twin(".las")) continue;
      if (path.extension() == ".csv" && has_twin(".bin2")) continue;  // planar, and a column beside
      if (names.insert(path.filename().string()).second) add(path, false);
    }
  }
  std::sort(sets.begin(), sets.end(), [](const CloudSet& a, const CloudSet& b) {
    return std::pair(a.weight, a.name) < std::pair(b.weight, b.name);
  });
  return sets;
}

Status write_npy(const fs::path& path, int dimension, const std::vector<double>& coordinates) {
  const std::size_t rows = coordinates.size() / static_cast<std::size_t>(dimension);
  std::string header = "{'descr': '<f8', 'fortran_order': False, 'shape': (" + std::to_string(rows) + ", " +
                       std::to_string(dimension) + "), }";
  header.resize((header.size() + 11 + 63) / 64 * 64 - 11, ' ');
  header += '\n';
  std::ofstream file(path, std::ios::binary);
  file << std::string("\x93NUMPY\x01\x00", 8) << static_cast<char>(header.size() & 0xff)
       << static_cast<char>(header.size() >> 8) << header;
  file.write(reinterpret_cast<const char*>(coordinates.data()),
             static_cast<std::streamsize>(coordinates.size() * sizeof(double)));
  file.close();
  if (!file) return error(Errc::io, path.string() + ": cannot be written");
  return success();
}

Result<fs::path> readable_file(const CloudSet& set, const fs::path& folder) {
  if (!raw_doubles(set)) return set.source;
  BOOST_OUTCOME_TRY(values, read_doubles(set.source));
  const fs::path copy = folder / (set.source.stem().string() + ".npy");
  BOOST_OUTCOME_TRYV(write_npy(copy, set.stored_dimension, values));
  return copy;
}

Result<std::vector<LocalPoint>> read_points(const CloudSet& set, int dimension) {
  std::vector<LocalPoint> points;
  const auto add = [&](Point p) {
    if (dimension == 2) p.z = 0;
    points.push_back({without_negative_zero(p), points.size()});
  };
  if (raw_doubles(set)) {
    BOOST_OUTCOME_TRY(values, read_doubles(set.source));
    const int d = set.stored_dimension;
    for (std::size_t i = 0; i + d <= values.size(); i += d) add({values[i], values[i + 1], d == 3 ? values[i + 2] : 0});
    return points;
  }
  BOOST_OUTCOME_TRY(reader, open_reader(set.source));
  PointBatch batch;
  do {
    BOOST_OUTCOME_TRYV(reader->next(batch));
    for (const Point& p : batch.points) add(p);
  } while (!batch.points.empty());
  return points;
}

}  // namespace tessera::testing
