// The change of a result as stages of the exchange, after the triangulation, on the real actors, under every fault.
// Each tile must have exactly the cells of CGAL's triangulation that have a vertex of its own.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "actors/harness/harness.h"
#include "src/delaunay/update/changed_program.h"
#include "src/delaunay/update/holes_program.h"
#include "src/geometry/reference/reference.h"

namespace tessera::testing {
namespace {

using Tiles = std::map<TileId, TileMesh>;

// As a shared folder: what was kept stays whatever happens.
class StoreInMemory final : public UpdateStore {
 public:
  explicit StoreInMemory(const Tiles& tiles) : tiles_(tiles) {}
  Result<TileMesh> read(TileId tile, bool cells) override {
    const auto found = tiles_.find(tile);
    if (found == tiles_.end()) return error(Errc::internal, "the triangulation has not come to its end");
    TileMesh mesh = found->second;
    if (!cells) mesh.cells = {};
    return mesh;
  }
  Status keep_told(TileId tile, const ToldOfHoles& told) override {
    const auto [at, fresh] = told_.try_emplace(tile, told);
    if (!fresh && bytes_of(at->second) != bytes_of(told))
      return error(Errc::internal, "another life of a tile was told something else");
    return success();
  }
  Result<ToldOfHoles> told(TileId tile) override { return told_.contains(tile) ? told_.at(tile) : ToldOfHoles{}; }
  Status store(TileId tile, TileEnd end, CollectedTile* cells) override {
    if (cells != nullptr) meshes_[tile] = std::move(*cells).whole();
    ends_[tile] = std::move(end);
    return success();
  }

  // Of the changed result.
  std::vector<TileMesh> meshes() const {
    std::vector<TileMesh> all;
    for (const auto& [tile, mesh] : tiles_) {
      const auto end = ends_.find(tile);
      if (end == ends_.end() || !end->second.changed) {
        all.push_back(mesh);
      } else if (meshes_.contains(tile)) {
        all.push_back(meshes_.at(tile));
      }
    }
    return all;
  }
  std::vector<TileReceipt> receipts(std::uint32_t stage) const {
    std::vector<TileReceipt> receipts;
    for (const auto& [tile, told] : told_)
      if (stage == 0) receipts.push_back({tile, {}});
    for (const auto& [tile, end] : ends_)
      if (stage == 1) receipts.push_back({tile, {}});
    return receipts;
  }
  std::uint64_t awake() const {
    return static_cast<std::uint64_t>(
        std::count_if(ends_.begin(), ends_.end(), [](const auto& end) { return end.second.awake; }));
  }

 private:
  const Tiles& tiles_;
  std::map<TileId, ToldOfHoles> told_;
  std::map<TileId, TileEnd> ends_;
  std::map<TileId, TileMesh> meshes_;
};

// A change that a seed draws.
class Change {
 public:
  Change(const Tiles& tiles, std::uint64_t seed) : rng_(seed) {
    for (const auto& [tile, mesh] : tiles) {
      dimension_ = mesh.dimension;
      tiles_.push_back(tile);
      for (std::size_t v = 0; v < mesh.ids.size(); ++v) {
        if (mesh.owners[v] != tile) continue;
        old_.push_back({{mesh.points[v], mesh.ids[v]}, tile});
        owners_[key(mesh.points[v])] = tile;
      }
    }
    std::sort(old_.begin(), old_.end(), [](const auto& a, const auto& b) { return a.first.id < b.first.id; });
    do {
      draw();
    } while (global_delaunay(after(), dimension_).empty());
  }
  std::vector<LocalPoint> after() const {
    std::vector<LocalPoint> all;
    for (const auto& [p, tile] : old_)
      if (!plan_.removed.contains(p.id)) all.push_back(p);
    for (const auto& [tile, points] : plan_.added) all.insert(all.end(), points.begin(), points.end());
    return all;
  }
  const UpdatePlan& plan() const { return plan_; }
  int dimension() const { return dimension_; }
  std::shared_ptr<const KnownFromStart> around() {
    const std::size_t count = tiles_.back().value + std::size_t{1};
    std::vector<Bounds> bounds(count);
    std::vector<std::vector<TileId>> touching(count);
    for (const TileId tile : tiles_) {
      bounds[tile.value].add(Point{0, 0, 0});
      for (const TileId other : tiles_)
        if (other != tile && rng_() % 3 != 0) touching[tile.value].push_back(other);
    }
    auto around = std::make_shared<KnownFromStart>(std::move(bounds), touching, std::vector<Seed>{});
    around->leave_out_fresh_bit();
    return around;
  }

 private:
  using Key = std::array<double, 3>;
  static Key key(const Point& p) { return {p.x, p.y, p.z}; }

  bool goes(const LocalPoint& p, TileId tile, int how, const Point& center, TileId emptied, double radius) {
    switch (how) {
      case 0:
        return false;
      case 1:
        return rng_() % old_.size() == 0;
      case 2:
        return rng_() % 4 == 0;
      case 3:
        return tile == emptied;
      case 4:
        return std::abs(p.at.x - center.x) <= radius;  // a wall
      case 5:
        return std::hypot(p.at.x - center.x, p.at.y - center.y, p.at.z - center.z) <= radius;
      default:
        return rng_() % 10 != 0;
    }
  }
  void draw() {
    plan_ = {};
    const auto& [middle, emptied] = old_[rng_() % old_.size()];
    const Point far = old_[rng_() % old_.size()].first.at;
    const double radius = std::abs(far.x - middle.at.x) / 2;
    const int how = static_cast<int>(rng_() % 7);
    for (const auto& [p, tile] : old_) {
      if (!goes(p, tile, how, middle.at, emptied, radius)) continue;
      plan_.removed.insert(p.id);
      plan_.losing.insert(tile);
    }
    plan_.first_new = old_.back().first.id.value + 1;
    std::uint64_t id = plan_.first_new;
    for (std::uint64_t k = how == 0 ? 1 + rng_() % 8 : rng_() % 8; k > 0; --k) add(PointId{id++});
    for (const auto& [p, tile] : old_) {
      const bool stays = !plan_.removed.contains(p.id);
      if (stays && (!plan_.common || rng_() % 3 == 0)) plan_.common = SharedPoint{p.at, p.id, tile, 0};
    }
    for (const auto& [tile, points] : plan_.added) {
      if (!plan_.common) plan_.common = SharedPoint{points[0].at, points[0].id, tile, fresh_bit};
    }
  }
  // Between old points, at the place of one, or far away. Equal points have one owner, as in a partition.
  void add(PointId id) {
    const Point a = old_[rng_() % old_.size()].first.at, b = old_[rng_() % old_.size()].first.at;
    const double t = rng_() % 6 == 0 ? 0 : rng_() % 8 == 0 ? 100 : static_cast<double>(rng_() % 16) / 8;
    const Point at = without_negative_zero({a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t, a.z + (b.z - a.z) * t});
    const TileId tile = owners_.try_emplace(key(at), tiles_[rng_() % tiles_.size()]).first->second;
    plan_.added[tile].push_back({at, id});
  }

  std::mt19937_64 rng_;
  int dimension_ = 3;
  std::vector<TileId> tiles_;
  std::vector<std::pair<LocalPoint, TileId>> old_;
  std::map<Key, TileId> owners_;
  UpdatePlan plan_;
};

// Made when the triangulation stands: what all tiles must know depends on it.
class WhenAllStand final : public TilePrograms {
 public:
  explicit WhenAllStand(std::function<std::shared_ptr<const UpdateSetting>()> setting, std::uint32_t stage)
      : setting_(std::move(setting)), stage_(stage) {}
  std::unique_ptr<TileProgram> program_of(TileId tile) const override {
    if (stage_ == 0) return std::make_unique<HolesProgram>(tile, setting_());
    return std::make_unique<ChangedProgram>(tile, setting_());
  }

 private:
  std::function<std::shared_ptr<const UpdateSetting>()> setting_;
  std::uint32_t stage_;
};

std::set<IdCell> cells_of_own(const TileMesh& mesh) {
  std::set<IdCell> cells;
  const auto corners = static_cast<std::size_t>(mesh.dimension) + 1;
  for (std::size_t at = 0; at < mesh.cells.size(); at += corners) {
    IdCell cell{infinite_id, infinite_id, infinite_id, infinite_id};
    for (std::size_t i = 0; i < corners; ++i) cell[i] = mesh.ids[static_cast<std::size_t>(mesh.cells[at + i])];
    std::sort(cell.begin(), cell.end());
    cells.insert(cell);
  }
  return cells;
}

class ChangeOfTiles final : public LaterStages {
 public:
  ChangeOfTiles(std::uint64_t seed, std::uint64_t& awake) : seed_(seed), awake_(awake) {}
  std::uint32_t count() const override { return 2; }
  std::uint64_t unbuilt_bytes() const override { return 1000; }
  std::shared_ptr<const TilePrograms> programs(std::uint32_t stage, const Tiles& tiles) override {
    return std::make_shared<WhenAllStand>(
        [this, &tiles] {
          if (!setting_) make(tiles);
          return setting_;
        },
        stage);
  }
  std::vector<TileReceipt> stored(std::uint32_t stage) const override {
    return store_ ? store_->receipts(stage) : std::vector<TileReceipt>();
  }
  std::string wrong(const Tiles&) const override {
    awake_ += store_->awake();
    const std::vector<TileMesh> meshes = store_->meshes();
    const std::vector<LocalPoint> points = change_->after();
    const auto expected = global_delaunay(points, change_->dimension());
    if (std::string differs = difference(expected, main_cells(meshes)); !differs.empty()) return differs;
    for (const TileMesh& mesh : meshes) {
      std::set<PointId> own;
      for (std::size_t v = 0; v < mesh.ids.size(); ++v)
        if (mesh.point_ghost[v] == 0) own.insert(mesh.ids[v]);
      std::set<IdCell> of_tile;
      for (const IdCell& cell : expected) {
        if (std::any_of(cell.begin(), cell.end(), [&](PointId id) { return own.contains(id); })) of_tile.insert(cell);
      }
      if (cells_of_own(mesh) != of_tile) return "a tile has other cells than those with a vertex of its own";
    }
    return "";
  }

 private:
  void make(const Tiles& tiles) {
    change_ = std::make_unique<Change>(tiles, seed_);
    store_ = std::make_shared<StoreInMemory>(tiles);
    setting_ =
        std::make_shared<const UpdateSetting>(UpdateSetting{.dimension = change_->dimension(),
                                                            .plan = std::make_shared<const UpdatePlan>(change_->plan()),
                                                            .around = change_->around(),
                                                            .store = store_,
                                                            .result = "result"});
  }
  std::uint64_t seed_;
  std::uint64_t& awake_;
  std::unique_ptr<Change> change_;
  std::shared_ptr<StoreInMemory> store_;
  std::shared_ptr<const UpdateSetting> setting_;
};

// A fresh point is answered, another one is not. Whether a point is fresh does not depend on the sender's routing
// table.
TEST(ChangedProgram, BelievesTheFreshBitOfAnotherTable) {
  TileMesh square;
  square.dimension = 2;
  square.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  square.ids = {PointId{0}, PointId{1}, PointId{2}, PointId{3}};
  square.owners.assign(4, TileId{1});
  square.point_ghost.assign(4, 0);
  const Tiles tiles{{TileId{1}, square}};
  std::vector<Bounds> bounds(2);
  for (Bounds& b : bounds) b.add(Point{0, 0, 0});
  auto around = std::make_shared<KnownFromStart>(
      std::move(bounds), std::vector<std::vector<TileId>>{{TileId{1}}, {TileId{0}}}, std::vector<Seed>{});
  around->leave_out_fresh_bit();
  const auto setting =
      std::make_shared<const UpdateSetting>(UpdateSetting{.dimension = 2,
                                                          .plan = std::make_shared<const UpdatePlan>(),
                                                          .around = around,
                                                          .store = std::make_shared<StoreInMemory>(tiles),
                                                          .result = "result"});
  for (const bool fresh : {true, false}) {
    ChangedProgram program(TileId{1}, setting);
    ASSERT_TRUE(program.begin());
    const SharedPoint point{{0.4, 0.5, 0}, PointId{9}, TileId{0}, fresh ? fresh_bit : 0};
    const auto bytes = std::as_bytes(std::span(&point, 1));
    ASSERT_TRUE(program.take(TileId{0}, false, Message(bytes.begin(), bytes.end())));
    ASSERT_TRUE(program.step());
    EXPECT_EQ(program.messages().empty(), !fresh);
  }
}

class ChangeOnActors : public ::testing::Test {
 protected:
  ChangeOnActors() {
    options_.dimension = 2;
    options_.points = 40;
    options_.tiles = 8;
    options_.later_stages = [this] { return std::make_unique<ChangeOfTiles>(++made_, awake_); };
  }
  HarnessReport run() {
    const char* wanted = std::getenv("UPDATE_EXCHANGE_SEEDS");  // nightly.sh runs more
    const std::uint64_t seeds = wanted == nullptr ? 80 : std::stoull(wanted);
    options_.last_seed = seeds;
    const HarnessReport report = run_harness(options_);
    EXPECT_FALSE(report.failed_seed) << "seed " << *report.failed_seed << ": " << report.failure;
    EXPECT_EQ(report.seeds, seeds);
    EXPECT_GT(awake_, seeds);
    return report;
  }
  void lattice(int dimension) {
    options_.kind = "lattice";
    options_.dimension = dimension;
  }
  HarnessOptions options_;
  std::uint64_t made_ = 0, awake_ = 0;
};

TEST_F(ChangeOnActors, IsCgalsTriangulation) {
  EXPECT_GT(run().sleeps, 0u);
  options_.dimension = 3;
  run();
}

TEST_F(ChangeOnActors, IsCgalsOfALattice) {
  lattice(2);
  run();
  lattice(3);
  options_.partition = PartitionKind::random;
  run();
}

TEST_F(ChangeOnActors, IsCgalsOfASphere) {
  options_.kind = "sphere";
  options_.dimension = 3;
  run();
}

TEST_F(ChangeOnActors, GoesOnAfterAccidentsAndRestarts) {
  lattice(2);
  options_.faults.storage = options_.restarts = true;
  EXPECT_GT(run().later_restarts, 0u);
}

TEST_F(ChangeOnActors, SurvivesLosses) {
  lattice(3);
  options_.nodes = 3;
  options_.faults.kill = options_.faults.pause = options_.faults.join = options_.faults.coordinator = true;
  EXPECT_GT(run().epochs, 0u);
}

TEST_F(ChangeOnActors, GoesOnElsewhereWhenNodesLeave) {
  lattice(2);
  options_.nodes = 3;
  options_.faults.leave = options_.faults.join = true;
  run();
}

TEST_F(ChangeOnActors, SurvivesAllAtOnce) {
  lattice(2);
  options_.partition = PartitionKind::random;
  options_.nodes = 3;
  options_.faults.kill = options_.faults.pause = options_.faults.join = options_.faults.coordinator = true;
  options_.faults.leave = options_.faults.last = options_.faults.all = true;
  run();
}

}  // namespace
}  // namespace tessera::testing
