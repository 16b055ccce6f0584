#include "actors/harness/setting.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "src/delaunay/run/touching.h"
#include "src/geometry/reference/clouds.h"
#include "src/geometry/reference/periodic_reference.h"
#include "src/tiling/affine_basis.h"
#include "src/tiling/seed_finder.h"

namespace tessera {
namespace {

void add_random_seeds(const std::vector<LocalPoint>& cloud, const Partition& partition, std::mt19937_64& rng,
                      std::vector<Seed>& seeds) {
  const std::uint64_t one_in = 1 + rng() % 8;
  for (const LocalPoint& p : cloud) {
    const auto is_point = [&](const Seed& s) { return s.point.id == p.id; };
    if (rng() % one_in != 0 || std::any_of(seeds.begin(), seeds.end(), is_point)) continue;
    const Point& other = cloud[rng() % cloud.size()].at;
    const double reach = std::hypot(p.at.x - other.x, p.at.y - other.y, p.at.z - other.z);
    seeds.push_back({{p.at, p.id, partition.tile_of(p.at), 0}, reach});
  }
}

// Periods of which some fold the cloud upon itself, and some leave room. Lattices stay lattices.
void make_periodic(int dimension, std::mt19937_64& rng, Setting& s) {
  Bounds bounds;
  for (const LocalPoint& p : s.cloud) bounds.add(p.at);
  const auto axes = static_cast<std::uint64_t>(dimension);
  const std::uint64_t all = (std::uint64_t{1} << axes) - 1, drawn = rng() % 2 == 0 ? all : 1 + rng() % all;
  Period period;
  for (int axis = 0; axis < dimension; ++axis) {
    const double size = bounds.hi[axis] - bounds.lo[axis], room[] = {size + 1, size * 2, size / 2, size / 16};
    if ((drawn >> axis & 1) != 0) period.length[static_cast<std::size_t>(axis)] = room[rng() % 4];
  }
  PeriodicCloud cloud = wrapped(dimension, s.cloud, period);
  s.cloud = std::move(cloud.points);
  s.period = cloud.period;
}

}  // namespace

CutCloud cut(const std::vector<LocalPoint>& cloud, const Partition& partition, const Period& period) {
  CutCloud out;
  out.tiles.resize(partition.tiles());
  out.bounds.resize(partition.tiles());
  AffineBasis span(partition.dimension(), period);
  SeedFinder seeds(partition.dimension(), period);
  for (const LocalPoint& p : cloud) {
    const TileId tile = partition.tile_of(p.at);
    out.tiles[tile.value].push_back(p);
    out.bounds[tile.value].add(p.at);
    seeds.add(tile, partition.boxes()[tile.value], p);
  }
  span.add(cloud);
  std::vector<LocalPoint> everywhere = span.span();
  if (!period.any() && std::find(everywhere.begin(), everywhere.end(), span.least()) == everywhere.end())
    everywhere.push_back(span.least());
  out.seeds = seeds.choose(partition, out.bounds, everywhere);
  return out;
}

std::shared_ptr<const std::vector<std::uint64_t>> points_of(const std::vector<std::vector<LocalPoint>>& tiles) {
  std::vector<std::uint64_t> points;
  for (const auto& tile : tiles) points.push_back(tile.size());
  return std::make_shared<const std::vector<std::uint64_t>>(std::move(points));
}

Setting make_setting(const HarnessOptions& options, std::uint64_t seed, std::mt19937_64& rng) {
  Setting s;
  const int d = options.dimension;
  s.cloud = make_cloud(options.kind, d, options.points, seed);
  if (options.periodic) make_periodic(d, rng, s);
  std::vector<Point> sample;
  Bounds bounds;
  for (const LocalPoint& p : s.cloud) {
    sample.push_back(p.at);
    bounds.add(p.at);
  }
  const auto cells =
      std::make_shared<const Partition>(Partition::build_tiles(options.partition, d, sample, bounds, options.tiles));
  const Partition& partition = *cells;
  auto [own, tile_bounds, known] = cut(s.cloud, partition, s.period);
  s.tiles = std::move(own);
  switch (rng() % 4) {
    case 0:  // only those that the proof needs
      std::erase_if(known, [](const Seed& seed) { return !std::isinf(seed.reach); });
      break;
    case 1:  // any points, each known in a random radius
      add_random_seeds(s.cloud, partition, rng, known);
      break;
    default:
      break;
  }
  s.stage.dimension = d;
  s.stage.reduce = rng() % 2 == 0;
  s.stage.early_points = rng() % 2 == 0 ? 0 : 1 + rng() % 16;
  s.stage.early_unit = 1 + rng() % 3;
  s.stage.boxes = final_boxes(cells, s.period);
  auto neighbours = touching_tiles(partition, tile_bounds, s.period);
  // No first exchange: the result depends on the rule alone.
  if (rng() % 3 == 0) neighbours.assign(partition.tiles(), {});
  s.stage.around =
      std::make_shared<const KnownFromStart>(std::move(tile_bounds), neighbours, std::move(known), s.period);
  constexpr std::uint64_t mail_bounds[] = {0, 120, 800, ~std::uint64_t{0}};
  s.context.mail_bytes_max = options.mail_bytes_max.value_or(mail_bounds[rng() % 4]);
  s.schedule.threads = 1 + static_cast<std::uint32_t>(rng() % 4);
  s.schedule.begin_bytes = s.schedule.collect_bytes = 1000;
  s.schedule.mail_growth = 2.5;
  // A budget of 1 makes every tile sleep whenever it can. Half the need leaves room for half of the tiles, beside those
  // that are falling asleep.
  const std::uint64_t half = s.cloud.size() * s.schedule.begin_bytes / 2;
  const std::uint64_t budgets[] = {1, half, std::uint64_t{1} << 40};
  s.schedule.memory_bytes = budgets[rng() % 3];
  s.nodes = options.nodes > 0 ? options.nodes : 1 + static_cast<std::uint32_t>(rng() % 3);
  for (std::size_t t = 0; t < s.tiles.size(); ++t) {
    s.spec.table.nodes.push_back(NodeId{static_cast<std::uint32_t>(rng() % s.nodes)});
    s.spec.table.incarnations.push_back({{}, static_cast<std::uint32_t>(rng() % 2)});
  }
  s.tile_points = points_of(s.tiles);
  s.table = std::make_shared<const RoutingTable>(s.spec.table);
  s.context.many_nodes = s.schedule.settle_asleep = s.nodes > 1 || options.faults.nodes();
  // Some networks are so slow that whole waves pass while an update is under way.
  s.patience = static_cast<std::uint32_t>(rng() % 7 == 0 ? 400 : rng() % 7);
  s.late_stores = rng() % 2 == 0;
  // Small windows make nodes wait for each other's credit after every few points.
  if (rng() % 2 == 0) s.outboxes = {.window_bytes = 800, .packet_bytes = 300};
  s.stage.kind = rng() % 3 == 0 ? TileKind::points : TileKind::cells;
  return s;
}

std::shared_ptr<const TilePrograms> MemoryShares::programs(Share& share, std::uint32_t stage) const {
  if (stage > 0) return later_->programs(stage - 1, storage_.meshes());
  auto delaunay = std::make_shared<DelaunayStage>(setting_.stage);
  delaunay->storage = &storage_.at(home_);
  delaunay->store = &storage_.store_at(home_);
  delaunay->stop = share.stopping.get_token();
  return delaunay;
}

std::vector<TileReceipt> MemoryShares::stored(std::uint32_t stage) const {
  return stage == 0 ? storage_.stored() : later_->stored(stage - 1);
}

Result<std::unique_ptr<Share>> MemoryShares::open(const ShareSpec& spec, NodeId self) {
  const Turn ours(storage_.memory_faults, false);
  auto share = std::make_unique<Share>();
  for (std::uint32_t stage = 0; stage < (later_ ? 1 + later_->count() : 1); ++stage) {
    ShareStage& one = share->stages.emplace_back(ShareStage{setting_.context, setting_.schedule, {}});
    one.context.storage = &storage_.at(home_, stage);
    one.context.programs = programs(*share, stage);
    one.context.watch = watches_.at(stage);
    if (stage > 0) one.schedule.unbuilt_bytes = later_->unbuilt_bytes();
    // As after a restart with a disk: that mail was for incarnations that are dead.
    BOOST_OUTCOME_TRYV(one.context.storage->clear(ScratchKind::mail));
  }
  share->table = spec.table == *setting_.table ? setting_.table : std::make_shared<const RoutingTable>(spec.table);
  share->outboxes = setting_.outboxes;
  share->weights = setting_.tile_points;
  share->settled = storage_.settled > spec.table.stage;
  const std::vector<TileReceipt> stored_there = stored(spec.table.stage);
  for (std::uint32_t t = 0; t < setting_.tiles.size(); ++t) {
    if (setting_.tiles[t].empty() || spec.table.node_of(TileId{t}) != self) continue;
    const auto kept = std::find_if(stored_there.begin(), stored_there.end(),
                                   [&](const TileReceipt& stored) { return stored.tile == TileId{t}; });
    if (kept != stored_there.end()) {
      share->stored.push_back(*kept);
    } else {
      TileStorage& storage = storage_.at(home_, spec.table.stage);
      BOOST_OUTCOME_TRY(alone, can_be_built_alone(storage, TileId{t}, setting_.context.many_nodes));
      share->settled = share->settled && alone;
    }
  }
  share->mail = std::make_unique<MailCounts>(map_regions_of({}, setting_.tiles.size(), MailCounts::regions_max));
  return share;
}

}  // namespace tessera
