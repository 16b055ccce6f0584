// One exchange over the tiles of a result that is changed, in a seeded, arbitrary order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/geometry/kernel/kernel.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "src/tiling/tile/changed_points.h"
#include "src/tiling/tile/tile_triangulation.h"
#include "tests/tile/changes.h"

namespace tessera::testing::changed {

using Rng = std::mt19937_64;
using Owner = std::function<std::uint32_t(const Point&)>;

struct Mail {
  std::uint32_t from, to;
  std::vector<SharedPoint> points;
  std::uint32_t from_life, to_life, epoch;
};

struct Tile {
  std::optional<TileMesh> mesh;             // stored
  std::unique_ptr<TileTriangulation> live;  // null: not live, or without points
  std::size_t seen = 0;                     // so many removed points the live tile has been told of
  // Of this change.
  ChangedPoints begin;
  std::vector<Point> points;
  std::vector<PointId> ids;
  bool begins = false;
  std::size_t added = 0;                 // of points, the last
  PointIds filled;                       // removed points: the tile knows all points around their holes
  std::vector<SharedPoint> around;       // these
  std::unique_ptr<TileTriangulation> t;  // null: asleep
  bool due = false;
  std::vector<Mail> waiting;
  std::uint32_t epoch = 0;
  std::set<TileId> reborn;  // to be told again
};

// A change of a cloud: what is removed and what is added.
struct Change {
  PointIds removed;
  std::vector<LocalPoint> added;
};

struct Setting {
  std::vector<PointId> removed;  // in all changes so far
  int dimension;
  std::uint32_t tiles;
  KernelKind kernel;
  Owner owner;
  std::size_t seen_before = 0;  // of removed: before this change
  const KnownFromStart* around;
  const ChangeOptions* options;
};

// One exchange over stored tiles. Tables of lives reach each tile at a time of its own; what was sent by the dead or to
// them is lost or comes late.
class Exchange {
 public:
  Exchange(const Setting& setting, std::vector<Tile>& tiles, Rng& rng, ChangeReport& report)
      : setting_(setting), tile_(tiles), rng_(rng), report_(report), lives_{std::vector<std::uint32_t>(tiles.size())} {
    for (Tile& t : tile_) {
      t.t.reset();
      t.due = false;
      t.waiting.clear();
      t.epoch = 0;
      t.reborn.clear();
    }
  }
  // Returns what is wrong, or "".
  std::string run(const Change& change, std::span<const SharedPoint> stayed);

 private:
  void prepare(const Change& change, std::span<const SharedPoint> stayed);
  void fill_holes(const Change& change, std::span<const SharedPoint> stayed);
  void choose_common(const Change& change, std::span<const SharedPoint> stayed);
  void know_least(Tile& tile, std::uint32_t self) const;
  void start(std::uint32_t i);
  void start_live(std::uint32_t i);
  void store(std::uint32_t i);
  void splay(std::uint32_t i);
  void sleep(std::uint32_t i);
  void post(std::uint32_t i);
  void deliver(std::size_t which);
  void lose();
  void rejoin(std::uint32_t i);
  bool act();
  TileOptions options_of(std::uint32_t i) const;
  bool mutant(Mutant m) const { return setting_.options->mutant == m; }
  std::uint32_t life(std::uint32_t i) const { return lives_.back()[i]; }
  bool coin() { return rng_() % 2 == 0; }

  const Setting& setting_;
  std::vector<Tile>& tile_;
  Rng& rng_;
  ChangeReport& report_;
  std::optional<SharedPoint> common_;
  std::vector<std::vector<std::uint32_t>> lives_;  // by epoch, then by tile
  std::vector<Mail> mail_;
  std::uint64_t losses_left_ = 0;
  std::uint64_t style_ = 0;
  std::string wrong_;
};

}  // namespace tessera::testing::changed
