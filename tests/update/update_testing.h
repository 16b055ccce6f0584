// A result that tests change again and again, and what it must be.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <random>
#include <set>
#include <stop_token>
#include <string>
#include <vector>

#include "src/delaunay/update/update.h"
#include "src/geometry/reference/clouds.h"
#include "tests/store/sample_result.h"
#include "tests/update/stored_cloud.h"

namespace tessera::testing {

namespace fs = std::filesystem;

// As the command does it, in this process.
Result<Updated> update_here(const fs::path& result, const ResultChange& change, const UpdateOptions& options,
                            std::stop_token stop = {}, std::uint64_t memory_bytes = std::uint64_t{1} << 30);

struct Case {
  std::string kind;
  int dimension;
  std::uint32_t tiles;
  PartitionKind partition;
  TileKind store;
  bool mixed = false;  // every third tile is of the other kind
};

class Update : public ::testing::Test {
 protected:
  // A result of all but a third of the points.
  void make(const Case& c, std::size_t count, std::uint64_t seed, bool attributes) {
    rng_.seed(seed);
    pool_.clear();
    for (const LocalPoint& p : make_cloud(c.kind, c.dimension, count, seed)) pool_.push_back(p.at);
    Bounds bounds;
    for (const Point& p : pool_) bounds.add(p);
    cloud_ = {};
    cloud_.dimension = c.dimension;
    cloud_.partition = Partition::build_tiles(c.partition, c.dimension, pool_, bounds, c.tiles);
    for (std::size_t i = 0; i < pool_.size() * 2 / 3; ++i) cloud_.points.push_back({pool_[i], PointId{i}});
    cloud_.points_read = cloud_.points.size();
    if (attributes) cloud_.schema = some_schema();
    cloud_.kind_of = [c](TileId tile) {
      const bool other = c.mixed && tile.value % 3 == 0;
      return other == (c.store == TileKind::cells) ? TileKind::points : TileKind::cells;
    };
    number_ = 0;
    cloud_.store(now());
  }
  fs::path now() const { return folder_.path() / ("r" + std::to_string(number_)); }
  fs::path next() const { return folder_.path() / ("r" + std::to_string(number_ + 1)); }

  ResultChange change(const std::vector<PointId>& remove, const std::vector<Point>& add) const {
    ResultChange out{.add = add, .rows = {}, .remove = remove};
    std::vector<PointId> ids;
    for (std::size_t i = 0; i < add.size(); ++i) ids.push_back(PointId{cloud_.points_read + i});
    if (!cloud_.schema.empty()) out.rows = cloud_.rows_of(ids);
    return out;
  }
  // The same change of the points themselves.
  void apply(const ResultChange& change) {
    const std::set<PointId> gone(change.remove.begin(), change.remove.end());
    std::erase_if(cloud_.points, [&](const LocalPoint& p) { return gone.contains(p.id); });
    for (const Point& p : change.add) cloud_.points.push_back({p, PointId{cloud_.points_read++}});
  }
  Updated update(const ResultChange& change, unsigned threads = 2) {
    auto updated = update_here(now(), change, {.to = next(), .threads = threads, .way = way_});
    EXPECT_TRUE(updated) << (updated ? "" : updated.error().where);
    if (!updated) return {};
    apply(change);
    ++number_;
    return updated.value();
  }
  std::string refusal(const ResultChange& change) const {
    const auto updated = update_here(now(), change, {.to = next(), .threads = 2, .way = way_});
    EXPECT_FALSE(updated);
    EXPECT_FALSE(fs::exists(next()));
    std::size_t left = 0;
    for ([[maybe_unused]] const auto& entry : fs::directory_iterator(folder_.path())) ++left;
    EXPECT_EQ(left, number_ + 1u) << "something is left";
    return updated ? "" : updated.error().where;
  }
  void expect_as_from_scratch() const;

  std::mt19937_64 rng_;
  std::vector<Point> pool_;
  StoredCloud cloud_;  // what the result is of
  const test::TemporaryFolder folder_;
  std::size_t number_ = 0;
  UpdateWay way_ = UpdateWay::exchange;
};

}  // namespace tessera::testing
