#include "src/delaunay/update/anew.h"

#include <algorithm>
#include <atomic>
#include <future>
#include <map>
#include <mutex>
#include <string>
#include <utility>

#include "src/base/files/names.h"
#include "src/base/files/update_names.h"
#include "src/base/flat_codec.h"
#include "src/base/on_threads.h"
#include "src/base/stopped.h"
#include "src/delaunay/delaunay_stage.h"
#include "src/delaunay/disk_store.h"
#include "src/delaunay/run/touching.h"
#include "src/delaunay/update/changed_tile.h"
#include "src/delaunay/update/rows_of_tiles.h"
#include "src/exchange/disk_scratch.h"
#include "src/tiling/affine_basis.h"
#include "src/tiling/budget/budget.h"
#include "src/tiling/routed_cloud.h"
#include "src/tiling/seed_finder.h"

namespace tessera {

namespace {

Result<TileMesh> read_mesh(const TileSource& source, TileId tile) {
  TileMesh mesh;
  mesh.dimension = source.manifest().dimension;
  if (const auto index = source.find(tile)) {
    BOOST_OUTCOME_TRY(stored, source.read(*index, {.cells = false}));
    mesh = std::move(stored.mesh);
  }
  return mesh;
}

// Whether points of the tile only go, or stay.
bool only_loses(const UpdatePlan& plan, TileId tile) { return plan.heirs.empty() && !plan.added.contains(tile); }

// REQUIRES: only_loses(). In the order of the mesh.
std::vector<LocalPoint> points_that_stay(const TileMesh& mesh, const UpdatePlan& plan) {
  std::vector<LocalPoint> left;
  left.reserve(mesh.ids.size());
  for (std::size_t v = 0; v < mesh.ids.size(); ++v) {
    if (mesh.point_ghost[v] == 0 && !plan.removed.contains(mesh.ids[v])) left.push_back({mesh.points[v], mesh.ids[v]});
  }
  return left;
}

Bounds bounds_of(std::span<const LocalPoint> points) {
  Bounds bounds;
  for (const LocalPoint& p : points) bounds.add(p.at);
  return bounds;
}

// The tile's points after the change: distinct, in any order.
Result<std::vector<LocalPoint>> points_left(const TileSource& source, const UpdatePlan& plan, TileId tile) {
  BOOST_OUTCOME_TRY(mesh, read_mesh(source, tile));
  if (only_loses(plan, tile)) return points_that_stay(mesh, plan);
  std::vector<LocalPoint> left;
  const StartOfTile start = start_of(tile, std::move(mesh), plan, {});
  for (std::size_t v = 0; v < start.points.size(); ++v) left.push_back({start.points[v], start.ids[v]});
  return left;
}

std::vector<TileId> tiles_with_points(const TileSource& source, const UpdatePlan& plan) {
  std::vector<TileId> tiles;
  for (const TileEntry& entry : source.manifest().tiles) tiles.push_back(entry.tile);
  for (const auto& [tile, points] : plan.added) tiles.push_back(tile);
  std::sort(tiles.begin(), tiles.end());
  tiles.erase(std::unique(tiles.begin(), tiles.end()), tiles.end());
  return tiles;
}

// What one thread has found.
struct Found {
  explicit Found(int dimension) : seeds(dimension) {}
  SeedFinder seeds;
  std::map<TileId, AffineBasis> spans;
};

}  // namespace

// The points of a tile are distinct, so the order in which they are looked at does not matter.
Result<AnewStart> find_anew_start(const TileSource& source, const Partition& partition, const UpdatePlan& plan,
                                  unsigned threads, const std::stop_token& stop) {
  const int dimension = partition.dimension();
  AnewStart start{.points = std::vector<std::uint64_t>(partition.tiles()),
                  .bounds = std::vector<Bounds>(partition.tiles()),
                  .seeds = {}};
  const std::vector<TileId> tiles = tiles_with_points(source, plan);
  Found all(dimension);
  std::mutex mutex;
  std::atomic<std::size_t> next{0};
  std::atomic<bool> failed{false};
  BOOST_OUTCOME_TRYV(on_threads(threads, failed, [&]() -> Status {
    Found found(dimension);
    for (std::size_t i = next++; i < tiles.size() && !failed; i = next++) {
      throw_if_stopped(stop);
      const TileId tile = tiles[i];
      BOOST_OUTCOME_TRY(points, points_left(source, plan, tile));
      AffineBasis span(dimension);
      for (const LocalPoint& p : points) {
        found.seeds.add(tile, partition.boxes()[tile.value], p);
        span.add(std::span(&p, 1));
        start.bounds[tile.value].add(p.at);
      }
      start.points[tile.value] = points.size();
      found.spans.emplace(tile, std::move(span));
    }
    const std::lock_guard lock(mutex);
    all.seeds.add(found.seeds, 0);
    all.spans.merge(found.spans);
    return success();
  }));
  AffineBasis span(dimension);
  for (const auto& [tile, of_tile] : all.spans) {
    if (of_tile.rank() >= 0) span.add(of_tile, 0);
  }
  if (!span.complete())
    return error(Errc::usage, source.folder().string() + ": the points that would be left all lie " +
                                  (dimension == 3 ? "in a plane" : "on a line") + ", so they have no triangulation");
  std::vector<LocalPoint> everywhere = span.span();
  if (std::find(everywhere.begin(), everywhere.end(), span.least()) == everywhere.end())
    everywhere.push_back(span.least());
  start.seeds = all.seeds.choose(partition, start.bounds, everywhere);
  return start;
}

BigVector<std::byte> bytes_of(const AnewStart& start) {
  FlatWriter out;
  out.list(start.points);
  out.list(start.bounds);
  out.list(start.seeds);
  return out.take();
}

std::optional<AnewStart> anew_start_of(std::span<const std::byte> bytes) {
  FlatReader in(bytes);
  AnewStart start;
  if (!in.list(start.points) || !in.list(start.bounds) || !in.list(start.seeds) || !in.at_end()) return std::nullopt;
  if (start.points.size() != start.bounds.size()) return std::nullopt;
  return start;
}

namespace {

class ChangedPointsOfResult final : public TilePoints {
 public:
  ChangedPointsOfResult(const ResultInput& input, const std::shared_ptr<const UpdatePlan>& plan)
      : source_(input.source), plan_(plan), rows_(input.source, plan, input.memory_bytes) {}
  int dimension() const override { return source_.manifest().dimension; }
  const std::vector<Attribute>& schema() const override { return source_.manifest().schema; }
  // Of equal points the first is kept; the others are known from changed().
  Result<LoadedTile> load(TileId tile) const override {
    BOOST_OUTCOME_TRY(mesh, read_mesh(source_, tile));
    if (only_loses(*plan_, tile)) return load_what_stays(tile, std::move(mesh));
    StartOfTile points = start_of(tile, std::move(mesh), *plan_, {});
    LoadedTile loaded;
    loaded.points = std::move(points.points);
    loaded.ids = std::move(points.ids);
    TileEnd end{.begun = true, .awake = true, .lost = points.lost, .changed = true};
    for (const Point& p : loaded.points) end.bounds.add(p);
    end.removed_bounds = points.removed_bounds;
    end.duplicates = std::move(points.duplicates);
    const std::lock_guard lock(mutex_);
    ends_[tile] = std::move(end);
    return loaded;
  }
  Result<std::vector<std::byte>> rows(TileId tile, std::span<const PointId> ids,
                                      std::span<const TileId> owners) const override {
    return rows_.of(tile, ids, owners);
  }
  // What becomes of a tile that was loaded, as far as it is known before its cells are stored.
  TileEnd take_end(TileId tile) const {
    const std::lock_guard lock(mutex_);
    auto node = ends_.extract(tile);
    return node.empty() ? TileEnd{} : std::move(node.mapped());
  }

 private:
  LoadedTile load_what_stays(TileId tile, TileMesh mesh) const {
    const std::vector<LocalPoint> left = points_that_stay(mesh, *plan_);
    TileEnd end{.begun = true, .awake = true, .changed = true, .bounds = bounds_of(left)};
    for (std::size_t v = 0; v < mesh.ids.size(); ++v) {
      if (mesh.point_ghost[v] != 0 || !plan_->removed.contains(mesh.ids[v])) continue;
      end.lost = true;
      end.removed_bounds.add(mesh.points[v]);
    }
    mesh = {};
    LoadedTile loaded;
    if (!end.lost) {  // the order is still that of the points
      for (const LocalPoint& p : left) {
        loaded.points.push_back(p.at);
        loaded.ids.push_back(p.id);
      }
    } else {
      loaded = order_points(left, dimension());
    }
    const std::lock_guard lock(mutex_);
    ends_[tile] = std::move(end);
    return loaded;
  }

  TileSource source_;
  std::shared_ptr<const UpdatePlan> plan_;
  mutable RowsOfTiles rows_;
  mutable std::mutex mutex_;
  mutable std::map<TileId, TileEnd> ends_;
};

// Stores tiles in the run folder, and keeps what they have become.
class AnewStore final : public DelaunayStore {
 public:
  AnewStore(std::shared_ptr<const ChangedPointsOfResult> points, DiskStore& disk, std::shared_ptr<UpdateStore> ends)
      : points_(std::move(points)), disk_(disk), ends_(std::move(ends)) {}
  Result<LoadedTile> load_points(TileId tile) override { return disk_.load_points(tile); }
  std::future<StoredEarly> store_early(TileId tile, std::shared_ptr<const EarlyFinals> cells) override {
    return disk_.store_early(tile, std::move(cells));
  }
  Status take_early(TileId tile, BigVector<std::byte>& stored) override { return disk_.take_early(tile, stored); }
  void store(TileId tile, CollectedTile collected, Finished::Stored done) override {
    disk_.store(tile, std::move(collected), keeping(tile, std::move(done)));
  }
  void store_points(TileId tile, PointsOfTile kept, Finished::Stored done) override {
    disk_.store_points(tile, std::move(kept), keeping(tile, std::move(done)));
  }

 private:
  Finished::Stored keeping(TileId tile, Finished::Stored done) {
    return [this, tile, done = std::move(done)](Result<Receipt> receipt) {
      if (!receipt) return done(std::move(receipt));
      done([&]() -> Result<Receipt> {
        TileEnd end = points_->take_end(tile);
        end.entry = tile_entry_of(receipt.value());
        if (!end.entry) return damaged(tile, "entry");
        BOOST_OUTCOME_TRYV(ends_->store(tile, std::move(end), nullptr));
        return Receipt();
      }());
    };
  }

  std::shared_ptr<const ChangedPointsOfResult> points_;
  DiskStore& disk_;
  std::shared_ptr<UpdateStore> ends_;
};

// Tiles of a result may be kept in two ways.
class AnewPrograms final : public TilePrograms {
 public:
  AnewPrograms(const ResultInput& input, std::uint32_t stage, const std::shared_ptr<const UpdatePlan>& plan,
               const Partition& partition, AnewStart start, std::shared_ptr<UpdateStore> ends)
      : source_(input.source),
        scratch_({stage_folder(input.run, stage), stage_folder(input.own, stage), input.seal, {}, input.node}),
        points_(std::make_shared<const ChangedPointsOfResult>(input, plan)),
        disk_(points_, update_result_folder(input.run),
              {.neighbors = input.source.manifest().neighbors,
               .schema = input.source.manifest().schema,
               .node = input.node,
               .sync = input.own != input.run,
               .stop = input.stop},
              input.threads + 1, scratch_, nullptr),
        store_(points_, disk_, std::move(ends)) {
    const int dimension = partition.dimension();
    const auto shared = std::make_shared<const Partition>(partition);
    const auto& all = source_.manifest().tiles;
    others_are_points_ = std::all_of(all.begin(), all.end(), [](const auto& e) { return e.kind == TileKind::points; });
    cells_.dimension = dimension;
    cells_.boxes = final_boxes(shared);
    const auto touching = touching_tiles(partition, start.bounds);
    const bool whole =
        budget::fits_whole(start.points, dimension, cells_.kernel, TileKind::cells, input.threads, input.tile_bytes);
    cells_.around = std::make_shared<const KnownFromStart>(std::move(start.bounds), touching, std::move(start.seeds));
    cells_.reduce = !whole;
    cells_.storage = &scratch_;
    cells_.store = &store_;
    cells_.stop = input.stop;
    points_stage_ = cells_;
    points_stage_.kind = TileKind::points;
  }
  std::unique_ptr<TileProgram> program_of(TileId tile) const override {
    const auto index = source_.find(tile);
    const bool points = index ? source_.entry(*index).kind == TileKind::points : others_are_points_;
    return (points ? points_stage_ : cells_).program_of(tile);
  }

 private:
  TileSource source_;
  DiskScratch scratch_;
  std::shared_ptr<const ChangedPointsOfResult> points_;
  DiskStore disk_;
  AnewStore store_;
  bool others_are_points_ = false;
  DelaunayStage cells_, points_stage_;
};

}  // namespace

Result<std::shared_ptr<const TilePrograms>> anew_programs(const ResultInput& input, std::uint32_t stage,
                                                          std::shared_ptr<const UpdatePlan> plan,
                                                          const Partition& partition, AnewStart start,
                                                          std::shared_ptr<UpdateStore> ends) {
  if (start.points.size() != partition.tiles()) return damaged(TileId{0}, "list of seeds");
  return std::shared_ptr<const TilePrograms>(
      std::make_shared<AnewPrograms>(input, stage, plan, partition, std::move(start), std::move(ends)));
}

}  // namespace tessera
