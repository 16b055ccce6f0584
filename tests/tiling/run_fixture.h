// A temporary folder with input files and run folders, and what must hold of every run in it.
#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "src/geometry/predicates/independent/predicates.h"
#include "src/tiling/routed_cloud.h"
#include "tests/tiling/clouds.h"

namespace tessera {

class RunFixture : public testing::Test {
 protected:
  RunFixture() {
    std::string name = (std::filesystem::temp_directory_path() / "tiling_test_XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
  }
  ~RunFixture() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path run_folder() const { return folder_ / "run"; }

  // NumPy's format, version 1.0: n rows of 2 or 3 little-endian doubles.
  std::string write_npy(const std::vector<Point>& points, int dimension, const std::string& name = "in.npy") const {
    std::string header = "{'descr': '<f8', 'fortran_order': False, 'shape': (" + std::to_string(points.size()) + ", " +
                         std::to_string(dimension) + "), }";
    header.resize(117, ' ');
    header += '\n';
    const auto path = folder_ / name;
    std::ofstream out(path, std::ios::binary);
    out.write("\x93NUMPY\x01\x00\x76\x00", 10);
    out << header;
    for (const Point& p : points) out.write(reinterpret_cast<const char*>(&p), dimension * 8);
    return path.string();
  }

  static CloudOptions in_dimension(int dimension) {
    CloudOptions options;
    options.dimension = dimension;
    return options;
  }

  static Cloud open_cloud(const std::string& path, int dimension) { return open_cloud(path, in_dimension(dimension)); }

  static Cloud open_cloud(const std::string& path, const CloudOptions& options) {
    auto cloud = Cloud::open({path}, options);
    if (!cloud) throw std::runtime_error(cloud.error().where);
    return std::move(cloud).value();
  }

  Result<RoutedCloud> route_points(const std::vector<Point>& points, int dimension, const RouteOptions& options) {
    return route(open_cloud(write_npy(points, dimension), dimension), run_folder(), options, progress_, {});
  }

  static std::vector<LocalPoint> read_points(const RoutedCloud& run, std::uint32_t tile) {
    std::vector<LocalPoint> points;
    EXPECT_TRUE(for_each_record({run.folder, run.bundles, 0}, run.segments_of(TileId{tile}), {},
                                [&](std::span<const LocalPoint> some, auto) -> Status {
                                  points.insert(points.end(), some.begin(), some.end());
                                  return success();
                                }));
    EXPECT_EQ(points.size(), run.tile_points.at(tile));
    return points;
  }

  // Every point is in its tile, under its rank in the input; the run's numbers are those of its files.
  static void expect_complete(const RoutedCloud& run, const std::vector<Point>& points) {
    ASSERT_EQ(run.tile_points.size(), run.partition.tiles());
    ASSERT_EQ(run.tile_bounds.size(), run.partition.tiles());
    std::vector<bool> seen(points.size());
    std::size_t total = 0;
    for (std::uint32_t t = 0; t < run.partition.tiles(); ++t) {
      const auto inside = read_points(run, t);
      Bounds bounds;
      for (std::size_t i = 0; i < inside.size(); ++i) {
        ASSERT_LT(inside[i].id.value, points.size());
        ASSERT_EQ(inside[i].at, points[inside[i].id.value]);
        ASSERT_EQ(run.partition.tile_of(inside[i].at).value, t);
        ASSERT_TRUE(i == 0 || inside[i - 1].id < inside[i].id);
        ASSERT_FALSE(seen[inside[i].id.value]);
        seen[inside[i].id.value] = true;
        bounds.add(inside[i].at);
      }
      ASSERT_EQ(bounds, run.tile_bounds[t]);
      total += inside.size();
    }
    EXPECT_EQ(total, points.size());
    EXPECT_EQ(run.bounds, bounds_of(points));
    expect_seeds(run, points);
  }

  // The least point is among them, d+1 of them span the space, and their ids are those of the vertices that are kept.
  static void expect_seeds(const RoutedCloud& run, const std::vector<Point>& points) {
    std::map<Point, std::uint64_t> lowest;
    for (std::size_t i = 0; i < points.size(); ++i) lowest.try_emplace(points[i], i);
    std::set<Point> distinct;
    std::vector<Point> everywhere;
    for (const Seed& s : run.seeds) {
      EXPECT_EQ(s.point.id.value, lowest.at(s.point.at));
      EXPECT_EQ(s.point.tile, run.partition.tile_of(s.point.at));
      EXPECT_TRUE(distinct.insert(s.point.at).second);
      EXPECT_GE(s.reach, 0);
      if (std::isinf(s.reach)) everywhere.push_back(s.point.at);
    }
    EXPECT_NE(std::find(everywhere.begin(), everywhere.end(), lowest.begin()->first), everywhere.end());
    bool spanned = false;
    const std::size_t n = everywhere.size();
    for (std::size_t i = 1; i < n && !spanned; ++i) {
      for (std::size_t k = i + 1; k < n && !spanned; ++k) {
        if (run.dimension == 2) {
          spanned = independent::orientation_2(everywhere[0], everywhere[i], everywhere[k]) != 0;
          continue;
        }
        for (std::size_t l = k + 1; l < n && !spanned; ++l) {
          spanned = independent::orientation_3(everywhere[0], everywhere[i], everywhere[k], everywhere[l]) != 0;
        }
      }
    }
    EXPECT_TRUE(spanned);
  }

  static void expect_same(const RoutedCloud& a, const RoutedCloud& b) {
    EXPECT_EQ(a.dimension, b.dimension);
    EXPECT_EQ(a.partition.kind(), b.partition.kind());
    EXPECT_EQ(a.partition.boxes(), b.partition.boxes());
    EXPECT_EQ(a.tile_points, b.tile_points);
    EXPECT_EQ(a.tile_bounds, b.tile_bounds);
    EXPECT_EQ(a.bundles, b.bundles);
    EXPECT_EQ(a.segments, b.segments);
    EXPECT_EQ(a.segment_end, b.segment_end);
    EXPECT_EQ(a.counts.read, b.counts.read);
    EXPECT_EQ(a.counts.invalid, b.counts.invalid);
    EXPECT_EQ(a.counts.filtered, b.counts.filtered);
    EXPECT_EQ(a.bounds, b.bounds);
    EXPECT_EQ(a.seeds, b.seeds);
    EXPECT_EQ(a.schema, b.schema);
    EXPECT_EQ(a.inputs, b.inputs);
    EXPECT_EQ(a.crs, b.crs);
    EXPECT_EQ(a.options_key, b.options_key);
  }

  std::filesystem::path folder_;
  Progress progress_;
};

inline std::string read_text(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

inline void write_text(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << text;
}

}  // namespace tessera
