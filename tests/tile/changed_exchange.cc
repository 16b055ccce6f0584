#include "tests/tile/changed_exchange.h"

#include <algorithm>
#include <utility>

#include "src/base/check.h"
#include "src/tiling/tile/holes.h"

namespace tessera::testing::changed {

TileOptions Exchange::options_of(std::uint32_t i) const {
  TileOptions out{TileId{i}, setting_.dimension, setting_.kernel, ExchangeRule::introduce, setting_.around};
  if (i % 2 == 0) out.rebuilt_from = 0;  // so that few points are enough to test both ways
  if (mutant(Mutant::foreign_pairs)) out.left_out = LeftOut::foreign_pairs;
  if (mutant(Mutant::old_arrivals)) out.left_out = LeftOut::old_arrivals;
  if (mutant(Mutant::refused_fresh)) out.left_out = LeftOut::refused_fresh;
  if (mutant(Mutant::answers)) out.left_out = LeftOut::answers;
  if (mutant(Mutant::forgotten_sent)) out.left_out = LeftOut::forgotten_sent;
  if (mutant(Mutant::forgotten_fresh)) out.left_out = LeftOut::forgotten_fresh;
  if (mutant(Mutant::forgotten_refused)) out.left_out = LeftOut::forgotten_refused;
  if (mutant(Mutant::replayed_quotes)) out.left_out = LeftOut::replayed_quotes;
  return out;
}

// Some of the holes that can be filled.
void Exchange::fill_holes(const Change& change, std::span<const SharedPoint> stayed) {
  for (Tile& t : tile_) {
    t.filled = {};
    t.around.clear();
  }
  std::vector<Point> points;
  for (const SharedPoint& p : stayed) points.push_back(p.at);
  const auto kernel = make_kernel(setting_.dimension, KernelKind::cgal);
  kernel->build(points, KeepPoints::copied, {});
  const bool span = kernel->dimension() == setting_.dimension;
  const std::uint64_t style = rng_() % 4;  // none, some, all
  for (std::uint32_t i = 0; i < setting_.tiles && span && style > 0 && !setting_.options->live; ++i) {
    if (!tile_[i].mesh) continue;
    for (const Hole& hole : find_holes(TileId{i}, *tile_[i].mesh, change.removed)) {
      if ((!hole.whole && !mutant(Mutant::shared_holes)) || (style == 1 && coin())) continue;
      tile_[i].filled.insert(hole.removed);
      for (const TileId beside : hole.beside) {
        Tile& t = tile_[beside.value];
        t.filled.insert(hole.removed);
        if (!mutant(Mutant::untold_holes)) t.around.insert(t.around.end(), hole.around.begin(), hole.around.end());
      }
    }
  }
}

void Exchange::prepare(const Change& change, std::span<const SharedPoint> stayed) {
  fill_holes(change, stayed);
  std::vector<std::vector<LocalPoint>> added(setting_.tiles);
  for (const LocalPoint& p : change.added) added[setting_.owner(p.at)].push_back(p);
  const bool seeds = rng_() % 4 == 0;
  for (std::uint32_t i = 0; i < setting_.tiles; ++i) {
    Tile& t = tile_[i];
    TileMesh nothing;
    nothing.dimension = setting_.dimension;
    t.begin = change_points(t.mesh ? *t.mesh : nothing, TileId{i}, change.removed, added[i], t.filled);
    for (const SharedPoint& p : t.around) {
      const bool knows =
          std::any_of(t.begin.foreign.begin(), t.begin.foreign.end(), [&](auto& f) { return f.id == p.id; });
      if (!knows && p.tile.value != i) t.begin.foreign.push_back(p);
    }
    if (mutant(Mutant::affected_not_fresh)) {
      for (std::size_t k = 0; k < t.begin.fresh.size(); ++k) {
        t.begin.fresh[k] = k + added[i].size() >= t.begin.fresh.size() ? 1 : 0;
      }
    }
    if (mutant(Mutant::removed_foreign) && t.mesh) {
      for (std::size_t v = 0; v < t.mesh->points.size(); ++v) {
        if (t.mesh->owners[v].value == i || !change.removed.contains(t.mesh->ids[v])) continue;
        t.begin.foreign.push_back({t.mesh->points[v], t.mesh->ids[v], t.mesh->owners[v], 0});
      }
    }
    t.begins = t.begin.begins();
    t.added = added[i].size();
    if (mutant(Mutant::begin_if_changed)) t.begins &= t.begin.lost || !added[i].empty();
    if (mutant(Mutant::no_foreign) && t.begins) t.begin.foreign.clear();
    for (const SharedPoint& p : stayed) {  // any point that stays may be known
      const bool knows =
          std::any_of(t.begin.foreign.begin(), t.begin.foreign.end(), [&](auto& f) { return f.id == p.id; });
      if (seeds && !knows && p.tile.value != i && rng_() % 4 == 0) t.begin.foreign.push_back(p);
    }
    t.points.clear();
    t.ids.clear();
    for (const LocalPoint& p : t.begin.own) {
      t.points.push_back(p.at);
      t.ids.push_back(p.id);
    }
  }
  choose_common(change, stayed);
}

void Exchange::choose_common(const Change& change, std::span<const SharedPoint> stayed) {
  std::vector<SharedPoint> added;
  for (const LocalPoint& p : change.added) added.push_back({p.at, p.id, TileId{setting_.owner(p.at)}, fresh_bit});
  std::vector<SharedPoint> from(stayed.begin(), stayed.end());
  if (from.empty() || (mutant(Mutant::new_common) && !added.empty())) from = added;
  if (mutant(Mutant::no_common) || from.empty()) return;
  common_ = from[rng_() % from.size()];
  if (!mutant(Mutant::least_common)) return;
  from.insert(from.end(), added.begin(), added.end());
  common_ = *std::min_element(from.begin(), from.end(), [](auto& a, auto& b) { return a.at < b.at; });
  for (std::uint32_t i = 0; i < setting_.tiles; ++i) know_least(tile_[i], i);
}

void Exchange::know_least(Tile& tile, std::uint32_t self) const {
  const auto below = [&](const auto& p) { return p.at < common_->at || p.at == common_->at; };
  if (!tile.begins || common_->tile.value == self) return;
  if (std::any_of(tile.begin.foreign.begin(), tile.begin.foreign.end(), below)) return;
  if (std::any_of(tile.begin.own.begin(), tile.begin.own.end(), below)) return;
  tile.begin.foreign.push_back({common_->at, common_->id, common_->tile, 0});
}

// The points that stay are known by the live tile, or are seeds.
void Exchange::start_live(std::uint32_t i) {
  Tile& t = tile_[i];
  if (t.live) {
    t.t = t.live->clone();
  } else {
    t.t = std::make_unique<TileTriangulation>(options_of(i));
    t.t->settle();
  }
  std::vector<LocalPoint> added(t.begin.own.end() - static_cast<std::ptrdiff_t>(t.added), t.begin.own.end());
  std::shuffle(added.begin(), added.end(), rng_);
  std::span<const PointId> removed(setting_.removed);
  removed = removed.subspan(mutant(Mutant::missed_removals) ? setting_.seen_before : t.seen);
  const auto changed = t.t->change(removed, added);
  if (!changed) {
    wrong_ = changed.error().where;
    return;
  }
  if (changed.value().lost != t.begin.lost || changed.value().begins != t.begins) {
    wrong_ = "tile " + std::to_string(i) + ": a live tile finds other fresh points";
  }
  std::shuffle(t.begin.foreign.begin(), t.begin.foreign.end(), rng_);
  Status known = t.t->know(t.begin.foreign);
  if (known && t.begins && common_) known = t.t->know_common(*common_);
  if (!known) wrong_ = known.error().where;
}

void Exchange::start(std::uint32_t i) {
  Tile& t = tile_[i];
  if (setting_.options->live) {
    start_live(i);
    t.due = true;
    ++report_.woken;
    report_.begun += t.begins ? 1 : 0;
    return;
  }
  t.t = std::make_unique<TileTriangulation>(options_of(i));
  std::shuffle(t.begin.foreign.begin(), t.begin.foreign.end(), rng_);
  std::optional<SharedPoint> common = t.begins ? common_ : std::nullopt;
  if (mutant(Mutant::least_common)) common.reset();
  if (mutant(Mutant::common_for_the_lonely) && !t.begin.foreign.empty()) common.reset();
  std::vector<std::uint8_t> fresh = t.begin.fresh;
  if (!t.begins) std::fill(fresh.begin(), fresh.end(), std::uint8_t{0});  // a mutant
  const Status begun = t.t->triangulate_changed({t.points, t.ids, fresh, t.begin.foreign, common});
  if (!begun) wrong_ = begun.error().where;
  t.due = true;
  ++report_.woken;
  report_.begun += t.begins ? 1 : 0;
}

void Exchange::sleep(std::uint32_t i) {
  auto again = std::make_unique<TileTriangulation>(options_of(i));
  if (!again->load(tile_[i].t->save())) wrong_ = "an image cannot be loaded";
  tile_[i].t = std::move(again);
}

void Exchange::splay(std::uint32_t i) {
  Tile& t = tile_[i];
  if (!t.t) start(i);
  if (!setting_.options->live && rng_() % 8 == 0) sleep(i);
  if (!t.reborn.empty()) {
    const std::vector<TileId> reborn(t.reborn.begin(), t.reborn.end());
    t.reborn.clear();
    if (mutant(Mutant::no_replay)) {
      t.t->forget_told_bits();
    } else {
      t.t->replay_to(reborn);
    }
  }
  std::shuffle(t.waiting.begin(), t.waiting.end(), rng_);
  for (Mail& mail : t.waiting) {
    for (SharedPoint& p : mail.points) {
      if (mail.epoch != t.epoch) p.told &= fresh_bit;
    }
    const Status received = t.t->receive(TileId{mail.from}, mail.points);
    if (!received) wrong_ = received.error().where;
  }
  t.waiting.clear();
  t.t->introduce();
  t.due = false;
  if (t.t->due()) wrong_ = "something is due after a splay";
  post(i);
}

void Exchange::post(std::uint32_t i) {
  const std::uint32_t epoch = tile_[i].epoch;
  for (auto& [to, points] : tile_[i].t->take_updates()) {
    report_.sent += points.size();
    const Mail mail{i, to.value, {}, life(i), lives_[epoch][to.value], epoch};
    if (coin()) {
      mail_.push_back(mail);
      mail_.back().points = std::move(points);
      continue;
    }
    for (const SharedPoint& p : points) {
      mail_.push_back(mail);
      mail_.back().points = {p};
    }
  }
}

void Exchange::deliver(std::size_t which) {
  std::swap(mail_[which], mail_.back());
  Mail mail = std::move(mail_.back());
  mail_.pop_back();
  Tile& to = tile_[mail.to];
  if (mail.to_life != life(mail.to) || mail.from_life < lives_[to.epoch][mail.from]) return;
  to.waiting.push_back(std::move(mail));
}

// One tile, half of them, or some with another. They begin with the last table.
void Exchange::lose() {
  --losses_left_;
  std::vector<bool> dead(setting_.tiles);
  const std::uint64_t how = rng_() % 3, one = rng_() % setting_.tiles;
  for (std::uint32_t i = 0; i < setting_.tiles; ++i) {
    dead[i] = how == 0 ? coin() : i == one || (how == 2 && rng_() % 4 == 0);
  }
  lives_.push_back(lives_.back());
  std::erase_if(mail_, [&](const Mail& mail) { return (dead[mail.from] || dead[mail.to]) && coin(); });
  for (std::uint32_t i = 0; i < setting_.tiles; ++i) {
    if (!dead[i]) continue;
    ++lives_.back()[i];
    ++report_.lost;
    Tile& t = tile_[i];
    t.t.reset();
    t.due = false;
    t.waiting.clear();
    t.reborn.clear();
    t.epoch = static_cast<std::uint32_t>(lives_.size()) - 1;
  }
}

// One table after the other, or the last at once.
void Exchange::rejoin(std::uint32_t i) {
  Tile& t = tile_[i];
  const std::uint32_t next = coin() ? t.epoch + 1 : static_cast<std::uint32_t>(lives_.size()) - 1;
  for (std::uint32_t k = 0; k < setting_.tiles; ++k) {
    if (k != i && t.t && lives_[next][k] != lives_[t.epoch][k]) t.reborn.insert(TileId{k});
  }
  t.epoch = next;
  std::erase_if(t.waiting, [&](const Mail& mail) { return mail.from_life < lives_[next][mail.from]; });
  t.due |= t.t != nullptr;
}

// Returns false when all is quiet.
bool Exchange::act() {
  std::vector<std::uint32_t> starts, splays, rejoins;
  for (std::uint32_t i = 0; i < setting_.tiles; ++i) {
    const Tile& t = tile_[i];
    if (t.begins && !t.t) starts.push_back(i);
    if (!t.waiting.empty() || (t.t && t.due)) splays.push_back(i);
    if (t.epoch + 1 < lives_.size()) rejoins.push_back(i);
  }
  if (!rejoins.empty() && rng_() % (style_ == 1 ? 2 : 6) == 0) return rejoin(rejoins[rng_() % rejoins.size()]), true;
  const std::size_t count = starts.size() + splays.size() + mail_.size();
  if (losses_left_ > 0 && (count == 0 ? coin() : rng_() % 10 == 0)) return lose(), true;
  if (count == 0) {
    if (rejoins.empty()) return false;
    return rejoin(rejoins[rng_() % rejoins.size()]), true;
  }
  std::size_t choice = rng_() % count;
  if (style_ == 1 && !mail_.empty() && rng_() % 4 != 0) choice = starts.size() + splays.size() + rng_() % mail_.size();
  if (style_ == 2 && !starts.empty() && coin()) choice = rng_() % starts.size();
  if (choice < starts.size()) {
    start(starts[choice]);
    if (coin()) splay(starts[choice]);
  } else if (choice < starts.size() + splays.size()) {
    splay(splays[choice - starts.size()]);
  } else {
    deliver(choice - starts.size() - splays.size());
  }
  return true;
}

std::string Exchange::run(const Change& change, std::span<const SharedPoint> stayed) {
  constexpr int steps_max = 200'000;
  prepare(change, stayed);
  style_ = rng_() % 3;  // lazy, prompt, mixed
  losses_left_ = setting_.options->losses ? 1 + rng_() % 3 : 0;
  for (int step = 0; wrong_.empty() && act(); ++step) {
    if (step == steps_max) wrong_ = "it does not end";
  }
  for (std::uint32_t i = 0; i < setting_.tiles && wrong_.empty(); ++i) {
    Tile& t = tile_[i];
    if (t.points.empty()) {
      t.mesh.reset();
      t.live.reset();
      continue;
    }
    if (!t.t && (t.begin.lost || t.begin.reshaped)) start(i);  // its cells follow from what is left
    if (!t.t) {
      if (!t.mesh) wrong_ = "tile " + std::to_string(i) + " has points and never began";
      continue;
    }
    if (t.t->kernel_dimension() < setting_.dimension) {
      wrong_ = "tile " + std::to_string(i) + " is flat";
    } else {
      store(i);
    }
  }
  for (Tile& t : tile_) {  // also those that slept
    if (t.live && wrong_.empty()) t.mesh = t.live->mesh(t.live->own());
  }
  return wrong_;
}

void Exchange::store(std::uint32_t i) {
  Tile& t = tile_[i];
  if (!setting_.options->live) {
    t.mesh = t.t->collect(t.points, t.ids, {}).whole();
    return;
  }
  t.t->settle();
  t.live = std::move(t.t);
  t.seen = setting_.removed.size();
}

}  // namespace tessera::testing::changed
