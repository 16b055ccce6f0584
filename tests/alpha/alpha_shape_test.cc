// Alpha shapes against CGAL's, for all kinds of clouds and tiles.
#include "src/result/alpha/alpha_shape.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "src/base/tile_kind.h"
#include "src/geometry/reference/alpha_reference.h"
#include "src/geometry/reference/clouds.h"
#include "tests/store/sample_result.h"

namespace tessera::test {
namespace {

namespace fs = std::filesystem;

// How a sample is cut into tiles.
struct Tiling {
  std::string name;
  std::uint32_t tiles = 1;
  bool random = false;
  TileKind kind = TileKind::cells;
};

const std::vector<Tiling>& tilings() {
  static const std::vector<Tiling> all{{"one", 1},
                                       {"seven", 7},
                                       {"sixty", 60},
                                       {"random", 9, true},
                                       {"points", 7, false, TileKind::points},
                                       {"random_points", 5, true, TileKind::points}};
  return all;
}

void store(const fs::path& out, const std::vector<Point>& points, int dimension, const Tiling& tiling) {
  const auto tile_of = [&](std::size_t i) { return static_cast<std::uint32_t>((i * 2654435761U) >> 7) % tiling.tiles; };
  const auto meshes = tiling.random ? sample_tiles(points, dimension, tiling.tiles, tile_of)
                                    : sample_tiles(points, dimension, tiling.tiles);
  store_sample(out, meshes, {}, {}, {}, [&](TileId) { return tiling.kind; });
}

IdFaces faces_of(const AlphaArrays& arrays, const std::vector<std::uint64_t>& flat, std::size_t size) {
  IdFaces faces;
  for (std::size_t i = 0; i < flat.size(); i += size) {
    std::vector<PointId> face;
    for (std::size_t k = 0; k < size; ++k) face.push_back(PointId{arrays.ids[flat[i + k]]});
    std::sort(face.begin(), face.end());
    faces.push_back(std::move(face));
  }
  std::sort(faces.begin(), faces.end());
  return faces;
}

AlphaArrays made(const fs::path& out, const AlphaOptions& options) {
  const auto shape = make_alpha_shape(out, options, {});
  EXPECT_TRUE(shape) << shape.error().where;
  return shape ? shape.value() : AlphaArrays{};
}

// Each edge of a facet (in 2D each vertex) is passed as often in one direction as in the other.
bool is_closed(const AlphaArrays& shape, int dimension) {
  std::map<std::pair<std::uint64_t, std::uint64_t>, int> balance;
  const auto d = static_cast<std::size_t>(dimension);
  for (std::size_t i = 0; i < shape.facets.size(); i += d) {
    if (dimension == 2) {
      ++balance[{shape.facets[i], 0}];
      --balance[{shape.facets[i + 1], 0}];
      continue;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint64_t a = shape.facets[i + k], b = shape.facets[i + (k + 1) % 3];
      balance[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  }
  return std::all_of(balance.begin(), balance.end(), [](const auto& one) { return one.second == 0; });
}

// d! times the volume within the facets, which is negative when they are turned inside out.
double volume_within(const AlphaArrays& shape, int dimension) {
  double sum = 0;
  const auto at = [&](std::size_t i, std::size_t axis) {
    return shape.points[shape.facets[i] * static_cast<std::size_t>(dimension) + axis] - shape.points[axis];
  };
  for (std::size_t i = 0; i < shape.facets.size(); i += static_cast<std::size_t>(dimension)) {
    if (dimension == 2) {
      sum += at(i, 0) * at(i + 1, 1) - at(i, 1) * at(i + 1, 0);
    } else {
      sum += at(i, 0) * (at(i + 1, 1) * at(i + 2, 2) - at(i + 1, 2) * at(i + 2, 1)) -
             at(i, 1) * (at(i + 1, 0) * at(i + 2, 2) - at(i + 1, 2) * at(i + 2, 0)) +
             at(i, 2) * (at(i + 1, 0) * at(i + 2, 1) - at(i + 1, 1) * at(i + 2, 0));
    }
  }
  return sum;
}

class AlphaShapes : public testing::TestWithParam<std::tuple<std::string, int>> {
 protected:
  static std::size_t size_of(const std::string& kind, int dimension) {
    if (dimension == 2) return 120;
    return kind == "curve" ? 20 : 60;
  }
  const std::string kind_ = std::get<0>(GetParam());
  const int dimension_ = std::get<1>(GetParam());
  const std::vector<LocalPoint> cloud_ = [&] {
    auto cloud = make_cloud(kind_, dimension_, size_of(kind_, dimension_), 7);
    for (std::size_t i = 0; i < cloud.size(); ++i) cloud[i].id = PointId{i};
    return cloud;
  }();
  const std::vector<Point> points_ = [&] {
    std::vector<Point> points;
    for (const LocalPoint& p : cloud_) points.push_back(p.at);
    return points;
  }();
  const TemporaryFolder folder_;
};

INSTANTIATE_TEST_SUITE_P(Clouds, AlphaShapes, testing::Combine(testing::ValuesIn(cloud_kinds()), testing::Values(2, 3)),
                         [](const auto& tested) {
                           return std::get<0>(tested.param) + "_" + std::to_string(std::get<1>(tested.param));
                         });

TEST_P(AlphaShapes, AreThoseOfCgalForAnyTiling) {
  const AlphaReference reference(cloud_, dimension_);
  const double least = reference.least_radius();
  ASSERT_GT(least, 0);
  const double optimal = reference.optimal_radius();
  EXPECT_TRUE(least <= optimal || !reference.is_one_piece(optimal));
  const std::vector<double> radii{least, std::nextafter(least, 0), least / 2, 0.5, 1, 1.5 * least, 1e300, 1e-300};
  for (const Tiling& tiling : tilings()) {
    SCOPED_TRACE(tiling.name);
    const fs::path out = folder_.path() / tiling.name;
    store(out, points_, dimension_, tiling);
    EXPECT_EQ(made(out, {.threads = 2}).radius, least);
    for (const double radius : radii) {
      SCOPED_TRACE(radius);
      ReferenceShape expected = reference.at(radius);
      // In 2D CGAL calls the vertices of singular edges singular, too; in 3D it does not.
      if (dimension_ == 2) {
        std::erase_if(expected.singular_vertices, [&](const auto& vertex) {
          return std::any_of(expected.singular_facets.begin(), expected.singular_facets.end(),
                             [&](const auto& edge) { return edge[0] == vertex[0] || edge[1] == vertex[0]; });
        });
      }
      const AlphaArrays shape = made(out, {.radius = radius, .general = true, .threads = 2});
      EXPECT_EQ(faces_of(shape, shape.facets, static_cast<std::size_t>(dimension_)), expected.facets);
      EXPECT_EQ(faces_of(shape, shape.singular_facets, static_cast<std::size_t>(dimension_)), expected.singular_facets);
      EXPECT_EQ(faces_of(shape, shape.singular_edges, 2), expected.singular_edges);
      EXPECT_EQ(faces_of(shape, shape.singular_vertices, 1), expected.singular_vertices);
      EXPECT_TRUE(is_closed(shape, dimension_));
      EXPECT_TRUE(std::is_sorted(shape.ids.begin(), shape.ids.end()));
      if (shape.facets.empty()) continue;
      EXPECT_GT(volume_within(shape, dimension_), 0);
      const AlphaArrays regular = made(out, {.radius = radius});
      EXPECT_EQ(faces_of(regular, regular.facets, static_cast<std::size_t>(dimension_)), expected.facets);
      EXPECT_TRUE(regular.singular_facets.empty() && regular.singular_vertices.empty());
    }
  }
}

std::string bytes_of_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST_P(AlphaShapes, HaveTheSameBytesForAnyTilingThreadsAndMemory) {
  std::map<std::string, std::string> first;
  const double radius = AlphaReference(cloud_, dimension_).least_radius();
  for (const Tiling& tiling : tilings()) {
    SCOPED_TRACE(tiling.name);
    const fs::path out = folder_.path() / tiling.name;
    store(out, points_, dimension_, tiling);
    for (const std::string name : {"a.ply", "a.geojson"}) {
      if (name == "a.geojson" && dimension_ == 3) continue;
      for (const double part : {1.0, 0.5}) {
        for (const bool general : {false, true}) {
          AlphaOptions options{.radius = part * radius, .general = general, .overwrite = true};
          options.threads = tiling.tiles;
          options.memory_bytes = tiling.random ? 1 : options.memory_bytes;
          const auto written = write_alpha_shape(out, folder_.path() / name, options, {});
          const std::string key = name + std::to_string(part) + std::to_string(general);
          const std::string bytes = written ? bytes_of_file(folder_.path() / name) : std::string();
          EXPECT_EQ(first.try_emplace(key, bytes).first->second, bytes) << key;
        }
      }
    }
  }
}

TEST(AlphaShape, RefusesRadiiThatAreNone) {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "out";
  store_sample(out, sample_tiles(sample_points(Shape::uniform, 2, 50), 2, 2));
  const double infinite = std::numeric_limits<double>::infinity();
  for (const double wrong : {0.0, -1.0, -0.0, infinite, -infinite, std::nan("")}) {
    const auto shape = make_alpha_shape(out, {.radius = wrong}, {});
    ASSERT_FALSE(shape);
    EXPECT_EQ(shape.error().code, Errc::usage);
  }
}

}  // namespace
}  // namespace tessera::test
