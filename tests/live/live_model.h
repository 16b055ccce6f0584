// What a live result must be: all points of a cloud that is changed by random batches, and CGAL's triangulation of
// them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/delaunay/live/live_version.h"
#include "src/delaunay/update/update.h"
#include "src/geometry/reference/reference.h"
#include "src/result/store/tile_store.h"
#include "src/tiling/partition.h"

namespace tessera::testing {

struct LiveCase {
  std::string kind;  // of a reference cloud
  int dimension = 3;
  std::uint32_t tiles = 7;
  PartitionKind partition = PartitionKind::kdtree;
  TileKind store = TileKind::cells;
  bool attributes = false;
  bool old_software = false;  // has made the result, so the attributes of duplicates are not kept
  bool grows = false;         // batches add many new places, so that tiles soon have many points
};

class LiveModel {
 public:
  // Two thirds of a cloud of `count` points are there from the beginning.
  LiveModel(const LiveCase& c, std::size_t count, std::uint64_t seed);
  void store(const std::filesystem::path& out) const;
  // The same in other tiles.
  Manifest store(const std::filesystem::path& out, const Partition& partition) const;

  // Counts batches, those that were refused, too.
  std::uint64_t version() const { return version_; }
  // Applies the next batch, or passes over it. Returns whether it was applied.
  bool go_on();
  // The batch that follows on this version: always the same one.
  ResultChange next() const;
  // Whether what the batch leaves spans space.
  bool allows(const ResultChange& change) const;
  void apply(const ResultChange& change);
  // Passes over a batch that was refused.
  void skip() { ++version_; }
  const std::map<PointId, Point>& points() const { return points_; }
  std::uint64_t first_new() const { return next_id_; }
  std::vector<IdCell> cells() const;

  // Returns what is wrong with a version of a live result, or "": its vertices, their stars, and where some points are.
  std::string compare(const LiveVersion& version) const;

 private:
  std::string compare_places(const LiveVersion& version, const std::vector<IdCell>& expected) const;
  std::vector<LocalPoint> list() const;

  LiveCase case_;
  std::uint64_t seed_;
  std::vector<Point> pool_;
  Partition partition_;
  std::map<PointId, Point> points_;
  std::uint64_t next_id_ = 0;
  std::uint64_t version_ = 0;
};

}  // namespace tessera::testing
