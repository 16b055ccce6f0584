#include "src/delaunay/live/live_result.h"

#include <algorithm>
#include <new>
#include <string>
#include <unordered_set>

#include "src/base/check.h"
#include "src/base/on_threads.h"
#include "src/base/stopped.h"
#include "src/base/too_large.h"
#include "src/delaunay/run/touching.h"
#include "src/tiling/hilbert.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

KnownFromStart known_from_start(const Partition& partition) {
  std::vector<Bounds> bounds(partition.tiles());
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    bounds[i].add(partition.boxes()[i].lo);
    bounds[i].add(partition.boxes()[i].hi);
  }
  const auto neighbours = touching_tiles(partition, bounds);
  KnownFromStart around(std::move(bounds), neighbours, std::vector<Seed>{});
  around.leave_out_fresh_bit();
  return around;
}

// Equal points have equal keys, so the least id comes first.
template <class AnyPoint>
void put_in_hilbert_order(std::vector<AnyPoint>& points, int dimension) {
  Bounds bounds;
  for (const auto& p : points) bounds.add(p.at);
  const HilbertKey key(bounds, dimension);
  std::sort(points.begin(), points.end(), [&](const AnyPoint& a, const AnyPoint& b) {
    return std::pair(key(a.at), a.id) < std::pair(key(b.at), b.id);
  });
}

Status check_kept(const fs::path& out, const Manifest& manifest) {
  if (manifest.keep != DuplicatePolicy::first)
    return error(Errc::usage, out.string() + ": keeps the " + std::string(name_of(manifest.keep)) +
                                  " of equal points, and a result that is kept in memory keeps the first");
  const auto of_masses = std::ranges::find_if(manifest.columns, depends_on_masses);
  if (of_masses != manifest.columns.end())
    return error(Errc::usage, out.string() + ": has the computed column '" + of_masses->name +
                                  "', which could not be computed again for new points whose mass is not finite");
  return success();
}

std::string megabytes(std::uint64_t bytes) { return std::to_string((bytes + 999'999) / 1'000'000) + " MB"; }

}  // namespace

LiveResult::LiveResult(TileSource source, Partition partition, const LiveOptions& options)
    : whole_(std::move(source)),
      source_(whole_.without_columns()),
      partition_(std::make_shared<const Partition>(std::move(partition))),
      around_(known_from_start(*partition_)),
      options_(options),
      next_id_(source_.manifest().points_read) {}

Error LiveResult::refuse(const std::string& why) const {
  return error(Errc::usage, source_.folder().string() + ": " + why);
}

Result<std::unique_ptr<LiveResult>> LiveResult::open(const fs::path& out, const LiveOptions& options,
                                                     const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(source, TileSource::open(out));
  BOOST_OUTCOME_TRYV(check_changeable(out, source.manifest()));
  BOOST_OUTCOME_TRYV(check_kept(out, source.manifest()));
  BOOST_OUTCOME_TRY(partition, Partition::from_json(source.manifest().partition));
  std::unique_ptr<LiveResult> live(new LiveResult(std::move(source), std::move(partition), options));
  BOOST_OUTCOME_TRYV(live->load(stop));
  const auto replay = [&](std::uint64_t first_new, const ResultChange& change) -> Status {
    if (stop.stop_requested())
      return error(Errc::interrupted, "interrupted while the log of " + out.string() + " is read");
    if (first_new != live->next_id_)
      return error(Errc::corrupt, out.string() + ": its log begins new points with source index " +
                                      std::to_string(first_new) + " where " + std::to_string(live->next_id_) +
                                      " follows");
    BOOST_OUTCOME_TRYV(live->apply_logged(change, false));
    return success();
  };
  const auto begin = [&](std::uint64_t number) {
    live->stored_number_ = number;
    const auto loaded = live->current();
    live->current_ = std::make_shared<const LiveVersion>(number, live->partition_, loaded->tiles(), loaded->ids());
  };
  BOOST_OUTCOME_TRY(log, LiveLog::open(out, live->source_.manifest(), begin, replay));
  live->log_.emplace(std::move(log));
  live->publish_state();
  return live;
}

// Triangulates what is stored. No point is fresh, so the tile has nothing to say.
Status LiveResult::load_tile(std::size_t index, LiveVersion::Tiles& tiles, std::vector<IdTiles::Entry>& entries) const {
  const TileId self = source_.entry(index).tile;
  BOOST_OUTCOME_TRY(stored, source_.read(index, {.cells = false}));
  const TileMesh& mesh = stored.mesh;
  std::vector<Point> points;
  std::vector<PointId> ids;
  std::vector<SharedPoint> foreign;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    if (mesh.owners[v] == self) {
      points.push_back(mesh.points[v]);
      ids.push_back(mesh.ids[v]);
      entries.emplace_back(mesh.ids[v], self);
    } else {
      foreign.push_back({mesh.points[v], mesh.ids[v], mesh.owners[v], 0});
    }
  }
  put_in_hilbert_order(foreign, partition_->dimension());
  const std::vector<std::uint8_t> fresh(points.size());
  const auto corrupt = [&](const std::string& why) {
    return error(Errc::corrupt, source_.file(index).string() + ": " + why);
  };
  try {
    auto made = std::make_unique<TileTriangulation>(
        TileOptions{.self = self, .dimension = partition_->dimension(), .around = &around_});
    const Status built = made->triangulate_changed({points, ids, fresh, foreign});
    if (!built) return corrupt("two of its vertices are equal");
    if (made->kernel_dimension() < partition_->dimension()) return corrupt("its vertices do not span space");
    made->settle();
    tiles[self.value] = std::make_shared<const LiveTile>(std::move(made));
  } catch (const Unsound&) {
    return corrupt("two of its vertices are equal");
  } catch (const TileTooLarge& e) {
    return error(Errc::memory, source_.file(index).string() + ": the tile " + e.what());
  }
  return success();
}

Status LiveResult::load(const std::stop_token& stop) {
  LiveVersion::Tiles tiles(partition_->tiles());
  std::vector<IdTiles::Entry> entries;
  std::mutex mutex;
  std::atomic<bool> failed{false};
  std::atomic<std::size_t> next{0}, memory{0};
  BOOST_OUTCOME_TRYV(on_threads(options_.threads, failed, [&]() -> Status {
    for (std::size_t i = next++; i < source_.tiles() && !failed; i = next++) {
      throw_if_stopped(stop);
      std::vector<IdTiles::Entry> of_tile;
      BOOST_OUTCOME_TRYV(load_tile(i, tiles, of_tile));
      memory += tiles[source_.entry(i).tile.value]->memory();
      if (memory > options_.memory_bytes)
        return error(Errc::memory, source_.folder().string() + ": its tiles need more than " +
                                       megabytes(options_.memory_bytes) +
                                       " in memory; allow more, or do not keep it in memory");
      const std::lock_guard lock(mutex);
      entries.insert(entries.end(), of_tile.begin(), of_tile.end());
    }
    return success();
  }));
  BOOST_OUTCOME_TRYV(load_duplicates(entries));
  current_ = std::make_shared<const LiveVersion>(0, partition_, std::move(tiles), IdTiles().with(std::move(entries)));
  return success();
}

Status LiveResult::load_duplicates(std::vector<IdTiles::Entry>& entries) {
  const Manifest& manifest = source_.manifest();
  duplicates_have_rows_ = !manifest.schema.empty();
  if (manifest.duplicates_xxh3 == 0) return success();
  BOOST_OUTCOME_TRY(pairs, read_duplicates(source_.folder(), manifest));
  BOOST_OUTCOME_TRY(rows, DuplicateRows::open(source_.folder(), manifest));
  duplicates_have_rows_ = rows.has_value();
  duplicates_ = LiveDuplicates(pairs);
  const IdTiles vertices = IdTiles().with(entries);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto tile = vertices.find(pairs[i].kept);
    if (!tile)
      return error(Errc::corrupt, source_.folder().string() + ": point " + to_string(pairs[i].duplicate) +
                                      " is a duplicate of point " + to_string(pairs[i].kept) + ", which is no vertex");
    entries.emplace_back(pairs[i].duplicate, *tile);
    if (!rows) continue;
    const auto row = rows->row(i);
    duplicate_rows_[pairs[i].duplicate].assign(row.begin(), row.end());
  }
  return success();
}

const std::vector<std::byte>* LiveResult::row_of_duplicate(PointId id) const {
  for (const auto* rows : {&rows_, &duplicate_rows_}) {
    if (const auto found = rows->find(id); found != rows->end()) return &found->second;
  }
  return nullptr;
}

Status LiveResult::check_points(const ResultChange& change) const {
  const Manifest& manifest = source_.manifest();
  if (change.rows.size() != change.add.size() * row_bytes(manifest.schema))
    return refuse("the attributes of the new points have " + std::to_string(change.rows.size()) + " bytes, but " +
                  std::to_string(change.add.size()) + " points of this result have " +
                  std::to_string(change.add.size() * row_bytes(manifest.schema)));
  for (std::size_t i = 0; i < change.add.size(); ++i) {
    if (!is_finite(change.add[i]))
      return refuse("new point " + std::to_string(i) + " has a coordinate that is not finite");
    if (manifest.dimension == 2 && change.add[i].z != 0)
      return refuse("new point " + std::to_string(i) + " has a height, but the result is a triangulation in the plane");
  }
  return success();
}

Status LiveResult::plan_removal(const LiveVersion& before, const std::vector<PointId>& ids, Planned& planned) const {
  std::vector<std::pair<PointId, TileId>> vertices;
  const std::set<PointId> wanted(ids.begin(), ids.end());
  for (const PointId id : wanted) {
    if (duplicates_.has(id)) {
      planned.duplicates_removed.push_back(id);
      continue;
    }
    const auto at = before.point(id);
    if (!at)
      return refuse("there is no point " + to_string(id) +
                    " to remove: no vertex and no duplicate of this result has this source index");
    const TileId tile = *before.ids().find(id);
    planned.batch.removed[tile].push_back(id);
    planned.removed_of[tile].add(*at);
    const auto* also = duplicates_.of(id);
    if (!also) continue;
    const auto heir = std::find_if(also->begin(), also->end(), [&](PointId other) { return !wanted.contains(other); });
    if (heir == also->end()) continue;
    if (!source_.manifest().schema.empty() && !row_of_duplicate(*heir))
      return refuse("point " + to_string(id) + " cannot be removed alone: point " + to_string(*heir) +
                    " has the same coordinates and would take its place, and this result of older software does not "
                    "have the attributes of that point; remove both");
    planned.heirs[id] = *heir;
    planned.batch.added[tile].push_back({*at, *heir});
  }
  return success();
}

Result<LiveResult::Planned> LiveResult::plan(const LiveVersion& before, const ResultChange& change) const {
  BOOST_OUTCOME_TRYV(check_points(change));
  Planned planned;
  BOOST_OUTCOME_TRYV(plan_removal(before, change.remove, planned));
  for (std::size_t i = 0; i < change.add.size(); ++i) {
    const Point p = without_negative_zero(change.add[i]);
    const TileId tile = partition_->tile_of(p);
    planned.batch.added[tile].push_back({p, PointId{next_id_ + i}});
    planned.entries.emplace_back(PointId{next_id_ + i}, tile);
  }
  for (auto& [tile, points] : planned.batch.added) put_in_hilbert_order(points, partition_->dimension());
  return planned;
}

// If one tile is flat at the end, all are (docs/updates-design.md).
Status LiveResult::check_left(const LiveVersion& before, LiveExchange& exchange) const {
  auto vertices = static_cast<std::int64_t>(before.vertices());
  bool flat = false;
  for (const auto& [id, tile] : exchange.tiles()) {
    const auto own = static_cast<std::int64_t>(tile.triangulation->own_points());
    const auto& old = before.tiles()[id.value];
    vertices += own - (old ? static_cast<std::int64_t>(old->triangulation().own_points()) : 0);
    flat |= own > 0 && tile.triangulation->kernel_dimension() < partition_->dimension();
  }
  if (vertices == 0) return refuse("no points would be left");
  if (!flat) return success();
  return refuse(std::string("the points that would be left all lie ") +
                (partition_->dimension() == 3 ? "in a plane" : "on a line") + ", so they have no triangulation");
}

std::shared_ptr<const LiveVersion> LiveResult::next(const LiveVersion& before, const Planned& planned,
                                                    LiveExchange& exchange, std::set<TileId>& changed) const {
  LiveVersion::Tiles tiles = before.tiles();
  for (auto& [id, tile] : exchange.tiles()) {
    auto& here = tiles[id.value];
    if (tile.triangulation->own_points() == 0) {
      here.reset();
      changed.insert(id);
    } else if (tile.changed()) {
      tile.triangulation->settle();
      here = std::make_shared<const LiveTile>(std::move(tile.triangulation));
      changed.insert(id);
    }
  }
  return std::make_shared<const LiveVersion>(before.number() + 1, partition_, std::move(tiles),
                                             before.ids().with(planned.entries));
}

// The bytes of `next` and of the tiles of older versions that readers have; those that versions share count once. The
// version before `next` counts from the following batch on: its readers are mostly just about to take the new one.
std::size_t LiveResult::memory_with(const LiveVersion& next) {
  std::size_t bytes = next.memory();
  std::set<const LiveTile*> counted;
  for (const auto& tile : next.tiles()) counted.insert(tile.get());
  std::erase_if(older_, [](const auto& version) { return version.expired(); });
  for (const auto& older : older_) {
    const auto version = older.lock();
    if (!version) continue;
    for (const auto& tile : version->tiles()) {
      if (tile && counted.insert(tile.get()).second) bytes += tile->memory();
    }
  }
  return bytes;
}

// What apply_logged() changes besides the version.
void LiveResult::note(const Planned& planned, const ResultChange& change, const LiveApplied& applied) {
  for (const PointId id : planned.duplicates_removed) duplicates_.remove(id);
  for (const auto& [vertex, heir] : planned.heirs) {
    duplicates_.inherit(vertex, heir);
    if (const auto row = duplicate_rows_.extract(heir)) rows_.insert({heir, row.mapped()});
  }
  for (const DuplicatePair& pair : applied.duplicates) duplicates_.add(pair.duplicate, pair.kept);
  const std::size_t width = row_bytes(source_.manifest().schema);
  for (std::size_t i = 0; width > 0 && i < change.add.size(); ++i) {
    const auto row = std::span(change.rows).subspan(i * width, width);
    rows_[PointId{next_id_ + i}].assign(row.begin(), row.end());
  }
  for (const PointId id : change.remove) {
    rows_.erase(id);
    duplicate_rows_.erase(id);
  }
  filtered_ += applied.removed;
  next_id_ += change.add.size();
}

Result<LiveApplied> LiveResult::apply(const ResultChange& change) {
  const std::lock_guard lock(writer_);
  if (broken_) return *broken_;
  try {
    auto applied = apply_logged(change, true);
    publish_state();
    return applied;
  } catch (const std::bad_alloc&) {
    return worded([] { return error(Errc::memory, "no memory is left to change a result"); });
  }
}

Result<LiveApplied> LiveResult::apply_logged(const ResultChange& change, bool log) {
  const auto before = current();
  LiveApplied applied{.version = before->number(), .first_new = next_id_};
  if (change.add.empty() && change.remove.empty()) return applied;
  BOOST_OUTCOME_TRY(planned, plan(*before, change));
  for (const auto& [tile, ids] : planned.batch.removed) applied.removed += ids.size();
  applied.removed += planned.duplicates_removed.size();
  LiveExchange exchange(*before, around_, planned.batch, options_.threads);
  BOOST_OUTCOME_TRYV(exchange.run());
  BOOST_OUTCOME_TRYV(check_left(*before, exchange));
  for (const auto& [id, tile] : exchange.tiles()) {
    applied.begun += tile.change.begins ? 1 : 0;
    ++applied.awake;
    for (const auto& [duplicate, kept] : tile.change.duplicates) applied.duplicates.push_back({duplicate, kept});
    Bounds box = tile.triangulation->changed();
    if (const auto removed = planned.removed_of.find(id); removed != planned.removed_of.end()) box.add(removed->second);
    if (!box.empty()) applied.changed.push_back(box);
  }
  std::sort(applied.duplicates.begin(), applied.duplicates.end());
  std::set<TileId> changed;
  const auto version = next(*before, planned, exchange, changed);
  if (memory_with(*version) > options_.memory_bytes)
    return error(Errc::memory, source_.folder().string() + ": its tiles would need more than " +
                                   megabytes(options_.memory_bytes) +
                                   " in memory, with those of older versions that are still read");
  applied.version = version->number();
  if (log) {
    const Status written = log_->append(next_id_, change);
    if (!written) {
      broken_ = error(written.error().code, written.error().where + "; " + until_opened_again);
      return *broken_;
    }
  }
  note(planned, change, applied);
  changed_.merge(changed);
  older_.push_back(before);
  current_ = version;
  return applied;
}

TileSource LiveResult::source() const {
  const std::lock_guard lock(writer_);
  return source_;
}

LiveState LiveResult::state() const {
  const std::lock_guard lock(state_mutex_);
  return state_;
}

void LiveResult::publish_state() {
  LiveState now{.version = current()->number(),
                .stored = stored_number_,
                .stored_version = source_.manifest().version,
                .added = next_id_ - source_.manifest().points_read,
                .removed = filtered_,
                .log_bytes = log_ ? log_->bytes() : 0,
                .broken = broken_};
  const std::lock_guard lock(state_mutex_);
  state_ = std::move(now);
}

std::uint64_t LiveResult::log_bytes() const {
  const std::lock_guard lock(writer_);
  return log_->bytes();
}

}  // namespace tessera
