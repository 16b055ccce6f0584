#include "src/delaunay/update/equal_points.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/update/update_testing.h"

namespace tessera::testing {
namespace {

// Points at few places, most of them with duplicates, in changes of duplicates, vertices and whole places.
struct EqualCase {
  int dimension;
  std::uint32_t tiles;
  TileKind store;
  DuplicatePolicy keep;
  bool attributes = true;
};

class UpdateOfEqualPoints : public Update, public ::testing::WithParamInterface<EqualCase> {
 protected:
  Point some_place() {
    const auto axis = [&](int wide) { return static_cast<double>(rng_() % static_cast<unsigned>(wide)); };
    return GetParam().dimension == 2 ? Point{axis(8), axis(8), 0} : Point{axis(4), axis(4), axis(4)};
  }
  void make_equal() {
    const EqualCase& c = GetParam();
    rng_.seed(11);
    make({"lattice", c.dimension, c.tiles, PartitionKind::kdtree, c.store}, 8, 11, c.attributes);
    Bounds bounds;
    std::vector<Point> places;
    for (int i = 0; i < 400; ++i) places.push_back(some_place());
    for (const Point& p : places) bounds.add(p);
    cloud_.partition = Partition::build_tiles(PartitionKind::kdtree, c.dimension, places, bounds, c.tiles);
    cloud_.points.clear();
    for (std::size_t i = 0; i < places.size(); ++i) cloud_.points.push_back({places[i], PointId{i}});
    cloud_.points_read = places.size();
    cloud_.keep = c.keep;
    if (c.attributes) {
      cloud_.schema = {{"z", AttributeType::f64}, {"some", AttributeType::u32}};
      if (c.dimension == 3) cloud_.schema[0].name = "height";
      cloud_.row_of = row_with_height;
    }
    fs::remove_all(now());
    cloud_.store(now());
  }
};

TEST_P(UpdateOfEqualPoints, IsTheResultFromScratchWithTheAttributesOfThePointsThatAreLeft) {
  make_equal();
  for (int step = 0; step < 6; ++step) {
    SCOPED_TRACE("change " + std::to_string(step));
    std::vector<PointId> remove;
    const Point emptied = some_place();
    for (const LocalPoint& p : cloud_.points) {
      if (step == 2 ? p.at == emptied || p.at == Point{1, 1, 0} : rng_() % 4 == 0) remove.push_back(p.id);
    }
    std::vector<Point> add;
    for (int k = 0; k < (step == 1 ? 0 : 60); ++k) add.push_back(some_place());
    if (step == 3) add.push_back({9, 9, 0});
    if (step == 3) add.push_back({9, 9, 0});
    update(change(step == 4 ? std::vector<PointId>{} : remove, add), 2);
    expect_as_from_scratch();
  }
}

std::vector<EqualCase> equal_cases() {
  std::vector<EqualCase> out;
  for (const std::uint32_t tiles : {1, 7, 60}) {
    for (const TileKind store : {TileKind::cells, TileKind::points}) {
      out.push_back({3, tiles, store, DuplicatePolicy::first});
      for (const auto keep :
           {DuplicatePolicy::first, DuplicatePolicy::last, DuplicatePolicy::lowest, DuplicatePolicy::highest})
        out.push_back({2, tiles, store, keep});
    }
  }
  out.push_back({2, 7, TileKind::cells, DuplicatePolicy::first, false});
  out.push_back({2, 7, TileKind::points, DuplicatePolicy::last, false});
  return out;
}

INSTANTIATE_TEST_SUITE_P(Cases, UpdateOfEqualPoints, ::testing::ValuesIn(equal_cases()), [](const auto& info) {
  return std::string(name_of(info.param.keep)) + std::to_string(info.param.dimension) + "of" +
         std::to_string(info.param.tiles) + (info.param.store == TileKind::cells ? "cells" : "points") +
         (info.param.attributes ? "" : "alone");
});

}  // namespace
}  // namespace tessera::testing
