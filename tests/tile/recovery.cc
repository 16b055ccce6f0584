#include "tests/tile/recovery.h"

#include <algorithm>
#include <iterator>
#include <memory>
#include <random>
#include <utility>

#include "src/delaunay/delaunay_program.h"
#include "src/exchange/tile_life.h"
#include "tests/tile/scratch.h"

namespace tessera::testing {
namespace {

struct Life {
  Life(TileIncarnation self, const DelaunayStage& common, std::uint64_t mail_bytes_max,
       std::shared_ptr<const RoutingTable> table, std::vector<LocalPoint> points)
      : self(self), scratch(std::move(points), common.dimension), told(table->epoch.number) {
    auto stage = std::make_shared<DelaunayStage>(common);
    stage->storage = context.storage = &scratch;
    stage->store = &scratch;
    context.programs = std::move(stage);
    context.mail_bytes_max = mail_bytes_max;
    state = std::make_unique<TileLife>(self, context, std::move(table));
  }

  TileIncarnation self;
  Scratch scratch;
  TileContext context;
  std::unique_ptr<TileLife> state;
  std::uint32_t told;  // the number of its table's epoch
  bool begun = false, awake = false;
  std::vector<TileIncarnation> waiting;  // from whom
};

class World {
 public:
  World(const std::vector<LocalPoint>& points, const Assignment& assignment, const RecoveryOptions& options);
  Recovered run();

 private:
  enum class Kind : std::uint8_t { begin, splay, rejoin, deliver };
  struct Action {
    Kind kind;
    std::size_t which;
  };
  std::vector<Action> possible();
  void act(const Action& action);
  void deliver(std::size_t which);
  void sleep();
  void lose();
  void birth(TileId tile);
  void rejoin(Life& life, std::uint32_t epoch);
  Life* life_of(std::size_t i) { return i < living_.size() ? living_[i].get() : zombies_[i - living_.size()].get(); }
  std::uint64_t under_way() const;
  bool all_told() const;
  bool quiet() const;
  void compare_counters();
  void collect();
  void fail(const std::string& what) {
    if (out_.wrong.empty()) out_.wrong = what;
  }
  void require(const Status& done) {
    if (!done) fail(done.error().where);
  }
  bool coin() { return rng_() % 2 == 0; }

  const RecoveryOptions& options_;
  std::mt19937_64 rng_;
  DelaunayStage common_;
  std::vector<std::vector<LocalPoint>> points_;                               // by tile
  std::vector<std::shared_ptr<const RoutingTable>> tables_;                   // of all epochs
  std::vector<std::shared_ptr<const IncarnationChanges>> rebirths_{nullptr};  // of the same
  std::shared_ptr<const RoutingTable> table_;                                 // the last
  std::vector<std::unique_ptr<Life>> living_;                                 // by tile; null where there are no points
  std::vector<std::unique_ptr<Life>> zombies_;
  std::vector<Update> mail_;  // under way
  Recovered out_;
};

World::World(const std::vector<LocalPoint>& points, const Assignment& assignment, const RecoveryOptions& options)
    : options_(options), rng_(options.seed) {
  const auto& tile_of = assignment.tile_of;
  const std::uint32_t tiles = *std::max_element(tile_of.begin(), tile_of.end()) + 1;
  points_.resize(tiles);
  std::vector<Bounds> bounds(tiles);
  for (std::size_t i = 0; i < points.size(); ++i) {
    points_[tile_of[i]].push_back(points[i]);
    bounds[tile_of[i]].add(points[i].at);
  }
  std::vector<Seed> seeds = make_seeds(points, tile_of, options.dimension, options.announced);
  if (options.random_seeds) add_random_seeds(points, tile_of, rng_, seeds);
  std::vector<std::vector<TileId>> neighbours(tiles);
  for (std::uint32_t i = 0; i < tiles && options.announce; ++i) {
    for (std::uint32_t k = 0; k < tiles; ++k) {
      if (k != i && !bounds[k].empty()) neighbours[i].push_back(TileId{k});
    }
  }
  common_.dimension = options.dimension;
  common_.kernel = options.kernel;
  common_.reduce = options.reduce;
  common_.boxes = std::make_shared<const std::vector<Box>>(
      assignment.boxes.empty() ? std::vector<Box>(tiles, Box{{1, 1, 1}, {-1, -1, -1}}) : assignment.boxes);
  common_.around = std::make_shared<const KnownFromStart>(bounds, neighbours, std::move(seeds));
  RoutingTable first{{}, 0, {}, std::vector<Incarnation>(tiles)};
  for (std::uint32_t t = 0; t < tiles; ++t) first.nodes.push_back(NodeId{static_cast<std::uint32_t>(rng_() % tiles)});
  table_ = std::make_shared<const RoutingTable>(std::move(first));
  tables_ = {table_};
  living_.resize(tiles);
  for (std::uint32_t t = 0; t < tiles; ++t) birth(TileId{t});
}

// With the table of now, or with an older one, which the others follow.
void World::birth(TileId tile) {
  if (points_[tile.value].empty()) return;
  const auto& table = coin() ? tables_.back() : tables_[rng_() % tables_.size()];
  auto life =
      std::make_unique<Life>(table_->peer_of(tile), common_, options_.mail_bytes_max, table, points_[tile.value]);
  if (living_[tile.value] && options_.images && coin()) life->scratch.inherit(living_[tile.value]->scratch);
  std::swap(living_[tile.value], life);
  if (life && rng_() % 3 == 0) zombies_.push_back(std::move(life));
}

// A node, one tile, or any tiles at once.
void World::lose() {
  RoutingTable next = *table_;
  ++next.epoch.number;
  std::vector<TileId> dead;
  const std::uint64_t how = rng_() % 4, one = rng_() % living_.size();
  for (std::uint32_t t = 0; t < living_.size(); ++t) {
    const bool lost = how == 0 ? coin() : how == 1 ? t == one : next.nodes[t] == table_->nodes[one];
    if (lost) dead.push_back(TileId{t});
  }
  for (const TileId tile : dead) {
    ++next.incarnations[tile.value].number;
    next.nodes[tile.value] = NodeId{static_cast<std::uint32_t>(rng_() % living_.size())};
  }
  rebirths_.push_back(incarnation_changes_between(*table_, next, rebirths_.back()));
  table_ = std::make_shared<const RoutingTable>(std::move(next));
  tables_.push_back(table_);
  for (const TileId tile : dead) birth(tile);
  std::erase_if(
      mail_, [&](const Update& update) { return !(table_->alive(update.from) && table_->alive(update.to)) && coin(); });
  ++out_.losses;
}

std::vector<World::Action> World::possible() {
  std::vector<Action> actions;
  for (std::size_t i = 0; i < living_.size() + zombies_.size(); ++i) {
    const Life* life = life_of(i);
    if (!life) continue;
    if (!life->begun) actions.push_back({Kind::begin, i});
    if (life->begun && !life->waiting.empty()) actions.push_back({Kind::splay, i});
    if (i < living_.size() && life->told < table_->epoch.number) actions.push_back({Kind::rejoin, i});
  }
  if (options_.prompt && rng_() % 8 != 0) {
    std::vector<Action> rejoins;
    std::copy_if(actions.begin(), actions.end(), std::back_inserter(rejoins),
                 [](const Action& action) { return action.kind == Kind::rejoin; });
    if (!rejoins.empty()) return rejoins;
  }
  for (std::size_t i = 0; i < mail_.size(); ++i) actions.push_back({Kind::deliver, i});
  return actions;
}

void World::act(const Action& action) {
  if (action.kind == Kind::deliver) return deliver(action.which);
  Life& life = *life_of(action.which);
  switch (action.kind) {
    case Kind::begin:
      require(life.state->begin());
      life.begun = life.awake = true;
      break;
    case Kind::splay:
      require(life.state->step());
      life.awake = true;
      life.waiting.clear();
      break;
    case Kind::rejoin:  // one table after the other, or the last at once
      life.told = coin() ? life.told + 1 : table_->epoch.number;
      rejoin(life, life.told);
      rejoin(life, rng_() % (life.told + 1));  // an old one says nothing
      break;
    case Kind::deliver:
      break;
  }
  for (Update& update : life.state->take_outgoing()) mail_.push_back(std::move(update));
}

void World::rejoin(Life& life, std::uint32_t epoch) { life.state->rejoin(tables_[epoch], rebirths_[epoch].get()); }

// What is for a dead tile arrives where it was, or at the living one, or nowhere.
void World::deliver(std::size_t which) {
  std::swap(mail_[which], mail_.back());
  Update update = std::move(mail_.back());
  mail_.pop_back();
  Life* to = living_[update.to.tile.value].get();
  const auto zombie =
      std::find_if(zombies_.begin(), zombies_.end(), [&](const auto& z) { return z->self == update.to; });
  if (zombie != zombies_.end()) to = zombie->get();
  if (to->self != update.to && coin()) return;
  const Incarnation oldest = tables_[to->told]->incarnations[update.from.tile.value];
  if (to->self == update.to && update.from.incarnation >= oldest) to->waiting.push_back(update.from);
  require(to->state->receive(std::move(update)));
  if (to->state->waiting_updates() != to->waiting.size())
    fail("a tile keeps mail of the dead, or loses that of others");
}

void World::sleep() {
  Life* life = life_of(rng_() % (living_.size() + zombies_.size()));
  if (!life || !life->awake) return;
  require(life->state->sleep());
  life->awake = false;
}

// Live updates that nobody has processed yet.
std::uint64_t World::under_way() const {
  std::uint64_t n = 0;
  for (const Update& update : mail_) n += table_->alive(update.from) && table_->alive(update.to) ? 1 : 0;
  for (const auto& life : living_) {
    if (!life) continue;
    for (const TileIncarnation from : life->waiting) n += table_->alive(from) ? 1 : 0;
  }
  return n;
}

bool World::all_told() const {
  return std::all_of(living_.begin(), living_.end(),
                     [&](const auto& life) { return !life || life->told == table_->epoch.number; });
}

bool World::quiet() const {
  const bool begun = std::all_of(living_.begin(), living_.end(), [](const auto& life) { return !life || life->begun; });
  return begun && all_told() && under_way() == 0;
}

// Whenever all tiles have the last table, their counters tell exactly what is under way.
void World::compare_counters() {
  if (!all_told()) return;
  Totals sum;
  for (const auto& life : living_) {
    if (life) sum += life->state->totals();
  }
  if (sum.sent - sum.processed != under_way()) fail("the counters do not tell what is under way");
}

void World::collect() {
  for (const auto& life : living_) {
    if (!life) continue;
    if (options_.settle) {
      require(life->state->settle());
      life->state = std::make_unique<TileLife>(life->self, life->context, tables_.back());
    }
    auto finished = life->state->finish();
    if (!finished) return fail(finished.error().where);
    out_.meshes.push_back(life->scratch.mesh_of(*finished.value()));
  }
}

Recovered World::run() {
  constexpr std::uint32_t steps_max = 100'000;
  for (std::uint32_t step = 0; out_.wrong.empty(); ++step) {
    if (step == steps_max) fail("it does not end");
    compare_counters();
    const bool still = quiet();
    if (out_.losses < options_.losses && (still ? coin() : rng_() % options_.patience == 0)) {
      lose();
      continue;
    }
    if (still) break;
    if (!zombies_.empty() && rng_() % 16 == 0) zombies_.erase(zombies_.begin());
    if (options_.sleep && rng_() % 8 == 0) sleep();
    const std::vector<Action> actions = possible();
    act(actions[rng_() % actions.size()]);
  }
  if (out_.wrong.empty()) collect();
  return std::move(out_);
}

}  // namespace

Recovered recover(const std::vector<LocalPoint>& points, const Assignment& assignment, const RecoveryOptions& options) {
  return World(points, assignment, options).run();
}

}  // namespace tessera::testing
