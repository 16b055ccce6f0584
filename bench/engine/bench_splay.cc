// The exchange alone, in memory, on one thread and without messages: all tiles are triangulated, then those with the
// shortest chain of mail behind them, and of these the one with most mail, splay until nothing waits. Simulates jobs of
// any number of tiles: tells what a tile says and hears, how long the chains are, and the digest of the result.
//
//   bench_splay --kind uniform -n 2000000 --tiles 1000
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <functional>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "actors/harness/memory_storage.h"
#include "src/base/option.h"
#include "src/delaunay/delaunay_program.h"
#include "src/delaunay/run/touching.h"
#include "src/exchange/tile_life.h"
#include "src/geometry/reference/periodic_reference.h"
#include "src/input/generate/generate.h"
#include "src/result/store/digest.h"
#include "src/tiling/affine_basis.h"
#include "src/tiling/seed_finder.h"

namespace tessera {
namespace {

struct Options {
  std::string kind = "uniform", partition = "kdtree";
  std::uint64_t points = 1'000'000, seed = 7, tiles = 8;
  int dimension = 3;
  bool seeds = true, announce = true, sleep = false, periodic = false;
};

double cpu_now() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// Clouds that are hard to splay, beside those of `tessera generate`.
Result<std::vector<LocalPoint>> cloud_of(const Options& o) {
  std::vector<LocalPoint> cloud;
  if (const auto shape = shape_named(o.kind)) {
    std::vector<Point> batch;
    std::vector<std::uint8_t> classes;
    for (PointGenerator generator({*shape, o.points, o.seed, o.dimension}); cloud.size() < o.points;) {
      generator.next(batch, classes);
      for (const Point& p : batch) cloud.push_back({p, cloud.size()});
    }
    return cloud;
  }
  std::mt19937_64 rng(o.seed);
  const auto real = [&] { return static_cast<double>(rng() >> 11) * 0x1p-53; };
  for (std::size_t i = 0; i < o.points; ++i) {
    Point p;
    if (o.kind == "exponential") {  // from e^-15 to e^15 away from every plane of coordinates
      for (int axis = 0; axis < o.dimension; ++axis) p[axis] = std::exp(real() * 30 - 15) * (rng() % 2 == 0 ? 1 : -1);
    } else if (o.kind == "moment") {
      const double t = real();
      p = {t, t * t, o.dimension == 3 ? t * t * t : 0};
    } else {
      return error(Errc::usage, "'" + o.kind + "' is not a kind of cloud");
    }
    cloud.push_back({p, i});
  }
  return cloud;
}

class Exchange {
 public:
  Exchange(const Options& o, const std::vector<LocalPoint>& cloud, const std::shared_ptr<const Partition>& cells,
           const Period& period)
      : o_(o), points_(cells->tiles()), bounds_(cells->tiles()) {
    const Partition& partition = *cells;
    AffineBasis span(o.dimension, period);
    SeedFinder finder(o.dimension, period);
    for (const LocalPoint& p : cloud) {
      const TileId t = partition.tile_of(p.at);
      points_[t.value].push_back(p);
      bounds_[t.value].add(p.at);
      finder.add(t, partition.boxes()[t.value], p);
    }
    span.add(cloud);
    std::vector<LocalPoint> everywhere = span.span();
    if (!period.any()) everywhere.push_back(span.least());
    std::vector<Seed> seeds = finder.choose(partition, bounds_, everywhere);
    if (!o.seeds) std::erase_if(seeds, [](const Seed& s) { return !std::isinf(s.reach); });
    auto neighbours = touching_tiles(partition, bounds_, period);
    if (!o.announce) neighbours.assign(partition.tiles(), {});
    stage_.dimension = o.dimension;
    stage_.boxes = final_boxes(cells, period);
    stage_.around = std::make_shared<const KnownFromStart>(bounds_, neighbours, std::move(seeds), period);
  }

  Status run() {
    MemoryStorage storage(o_.dimension, std::move(points_));
    stage_.storage = context_.storage = &storage.at(NodeId{0});
    stage_.store = &storage.store_at(NodeId{0});
    const auto table = std::make_shared<const RoutingTable>();
    context_.programs = std::make_shared<DelaunayStage>(stage_);
    for (std::uint32_t t = 0; t < bounds_.size(); ++t) {
      tiles_.push_back(std::make_unique<TileLife>(TileIncarnation{TileId{t}, {}}, context_, table));
    }
    const double begin = cpu_now();
    for (std::uint32_t t = 0; t < tiles_.size(); ++t) {
      if (bounds_[t].empty()) continue;
      BOOST_OUTCOME_TRYV(tiles_[t]->begin());
      BOOST_OUTCOME_TRYV(post(*tiles_[t]));
      BOOST_OUTCOME_TRYV(o_.sleep ? tiles_[t]->sleep() : success());
    }
    const double triangulated = cpu_now();
    std::uint64_t splays = 0;
    for (; !ready_.empty(); ++splays) {
      const std::uint32_t t = std::get<2>(*ready_.begin());
      ready_.erase(ready_.begin());
      BOOST_OUTCOME_TRYV(tiles_[t]->step());
      BOOST_OUTCOME_TRYV(post(*tiles_[t]));
      BOOST_OUTCOME_TRYV(o_.sleep ? tiles_[t]->sleep() : success());
    }
    return tell(storage, triangulated - begin, cpu_now() - triangulated, splays);
  }

 private:
  std::tuple<std::uint32_t, std::uint64_t, std::uint32_t> rank(std::uint32_t t) const {
    return {~tiles_[t]->waiting_hops(), tiles_[t]->waiting_bytes() + tiles_[t]->waiting_updates(), t};
  }

  Status post(TileLife& from) {
    for (Update& update : from.take_outgoing()) {
      const std::uint32_t to = update.to.tile.value;
      ready_.erase(rank(to));
      ++messages_;
      BOOST_OUTCOME_TRYV(tiles_[to]->receive(std::move(update)));
      ready_.insert(rank(to));
    }
    return success();
  }

  Status tell(const MemoryStorage& storage, double triangulating, double splaying, std::uint64_t splays) {
    ExchangeCounts sum;
    Digest digest;
    std::uint64_t chain = 0, seeds = 0;
    std::vector<std::uint64_t> received;
    for (std::uint32_t t = 0; t < tiles_.size(); ++t) {
      if (bounds_[t].empty()) continue;
      BOOST_OUTCOME_TRY(finished, tiles_[t]->finish());
      finished->store([](const Result<Receipt>&) {});
      digest += digest_of(storage.meshes().at(TileId{t}));
      sum += tiles_[t]->counts();
      chain = std::max<std::uint64_t>(chain, tiles_[t]->hops());
      seeds += stage_.around->seeds_of(TileId{t}).size();
      received.push_back(tiles_[t]->counts().received);
    }
    std::sort(received.begin(), received.end());
    const auto tiles = static_cast<double>(received.size()), kept = static_cast<double>(sum.useful);
    std::printf("%s, %zu points a tile, seed %llu, %dD, %.0f tiles, %s: digest %s\n", o_.kind.c_str(),
                static_cast<std::size_t>(static_cast<double>(o_.points) / tiles),
                static_cast<unsigned long long>(o_.seed), o_.dimension, tiles, o_.partition.c_str(),
                digest_text(digest).c_str());
    std::printf("  cpu: triangulating %.2f s, splaying %.2f s, %.2f of it\n", triangulating, splaying,
                splaying / triangulating);
    std::printf("  a tile: %.1f seeds, %.1f messages, %.1f splays; longest chain %llu\n",
                static_cast<double>(seeds) / tiles, static_cast<double>(messages_) / tiles,
                static_cast<double>(splays) / tiles, static_cast<unsigned long long>(chain));
    std::printf(
        "  %llu kept; to each: %.2f sent, %.2f inserted, %.2f refused; a tile received %llu at most, "
        "%llu in the median\n",
        static_cast<unsigned long long>(sum.useful), static_cast<double>(sum.sent) / kept,
        static_cast<double>(sum.inserted - seeds) / kept, static_cast<double>(sum.refused) / kept,
        static_cast<unsigned long long>(received.back()),
        static_cast<unsigned long long>(received[received.size() / 2]));
    return success();
  }

  const Options& o_;
  std::vector<std::vector<LocalPoint>> points_;  // by tile, until it begins
  std::vector<Bounds> bounds_;
  DelaunayStage stage_;
  TileContext context_;
  std::vector<std::unique_ptr<TileLife>> tiles_;
  std::set<std::tuple<std::uint32_t, std::uint64_t, std::uint32_t>, std::greater<>> ready_;
  std::uint64_t messages_ = 0;
};

Status run(const Options& o) {
  BOOST_OUTCOME_TRY(kind, parse_partition_kind(o.partition));
  BOOST_OUTCOME_TRY(cloud, cloud_of(o));
  std::vector<Point> sample;
  Bounds bounds;
  for (const LocalPoint& p : cloud) bounds.add(p.at);
  Period period;
  if (o.periodic) {
    for (int axis = 0; axis < o.dimension; ++axis) {
      period.length[static_cast<std::size_t>(axis)] = bounds.hi[axis] - bounds.lo[axis];
    }
    PeriodicCloud periodic = wrapped(o.dimension, cloud, period);
    cloud = std::move(periodic.points);
    period = periodic.period;
    bounds = {};
    for (const LocalPoint& p : cloud) bounds.add(p.at);
  }
  for (const LocalPoint& p : cloud) sample.push_back(p.at);
  const auto partition = std::make_shared<const Partition>(
      Partition::build_tiles(kind, o.dimension, sample, bounds, static_cast<std::uint32_t>(o.tiles)));
  return Exchange(o, cloud, partition, period).run();
}

}  // namespace
}  // namespace tessera

int main(int argc, char** argv) {
  tessera::Options o;
  CLI::App app("The exchange alone, on one thread");
  app.add_option("--kind", o.kind, "uniform, normal, sphere, grid, terrain, exponential, moment");
  app.add_option("-n,--points", o.points, "points");
  app.add_option("--seed", o.seed, "seed");
  app.add_option("--dim", o.dimension, "2 or 3");
  app.add_option("--tiles", o.tiles, "tiles");
  app.add_option("--partition", o.partition, "kdtree, grid, octree, random");
  app.add_flag("!--no-seeds", o.seeds, "only the seeds that all tiles have");
  app.add_flag("!--no-announce", o.announce, "no directed first exchange");
  app.add_flag("--periodic", o.periodic, "the sides of the cloud's box are the same place");
  app.add_flag("--sleep", o.sleep, "tiles sleep between splays: a fifth of the memory");
  CLI11_PARSE(app, argc, argv);
  const auto done = tessera::run(o);
  if (!done) std::fprintf(stderr, "bench_splay: %s\n", tessera::in_plain_words(done.error().where).c_str());
  return done ? 0 : 1;
}
