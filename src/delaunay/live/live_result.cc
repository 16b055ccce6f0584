#include "src/delaunay/live/live_result.h"

#include <algorithm>
#include <new>
#include <span>
#include <string>

#include "src/base/on_threads.h"
#include "src/base/stopped.h"
#include "src/delaunay/update/known_in_change.h"
#include "src/result/far_files.h"
#include "src/result/measure/made_again.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

// A new point may have a mass that is not finite, and then its change could not be stored.
Status check_columns(const fs::path& out, const Manifest& manifest) {
  const auto of_masses = std::ranges::find_if(manifest.columns, depends_on_masses);
  if (of_masses == manifest.columns.end()) return success();
  return error(Errc::usage, out.string() + ": has the computed column '" + of_masses->name +
                                "', which could not be computed again for new points whose mass is not finite");
}

std::string megabytes(std::uint64_t bytes) { return std::to_string((bytes + 999'999) / 1'000'000) + " MB"; }

}  // namespace

LiveResult::LiveResult(TileSource source, Partition partition, const LiveOptions& options)
    : whole_(std::move(source)),
      source_(whole_.without_columns()),
      partition_(std::make_shared<const Partition>(std::move(partition))),
      around_(known_in_change(*partition_)),
      options_(options),
      next_id_(source_.manifest().points_read) {
  stored_rows_.emplace(source_);
}

Error LiveResult::refuse(const std::string& why) const {
  return error(Errc::usage, source_.folder().string() + ": " + why);
}

Result<std::unique_ptr<LiveResult>> LiveResult::open(const fs::path& out, const LiveOptions& options,
                                                     const std::stop_token& stop) {
  BOOST_OUTCOME_TRYV(result::refuse_far(out));
  BOOST_OUTCOME_TRY(source, TileSource::open(out));
  BOOST_OUTCOME_TRYV(check_changeable(out, source.manifest()));
  BOOST_OUTCOME_TRYV(check_columns(out, source.manifest()));
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
    BOOST_OUTCOME_TRYV(live->check_points(change));
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

Status LiveResult::load_tile(std::size_t index, LiveVersion::Tiles& tiles, std::vector<IdTiles::Entry>& entries) const {
  const TileId self = source_.entry(index).tile;
  BOOST_OUTCOME_TRY(stored, source_.read(index, {.cells = false}));
  const TileMesh& mesh = stored.mesh;
  LiveTilePoints points{.self = self, .dimension = partition_->dimension(), .points = {}, .ids = {}, .foreign = {}};
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    if (mesh.owners[v] == self) {
      points.points.push_back(mesh.points[v]);
      points.ids.push_back(mesh.ids[v]);
      entries.emplace_back(mesh.ids[v], self);
    } else {
      points.foreign.push_back({mesh.points[v], mesh.ids[v], mesh.owners[v], 0});
    }
  }
  auto built = build_live_tile(std::move(points), around_);
  if (!built) return error(built.error().code, source_.file(index).string() + ": " + built.error().where);
  tiles[self.value] = std::move(built).value();
  return success();
}

Error LiveResult::too_little_memory() const {
  return error(Errc::memory, source_.folder().string() + ": its tiles need more than " +
                                 megabytes(options_.memory_bytes) +
                                 " in memory; allow more, or do not keep it in memory");
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
      if (memory > options_.memory_bytes) return too_little_memory();
      const std::lock_guard lock(mutex);
      entries.insert(entries.end(), of_tile.begin(), of_tile.end());
    }
    return success();
  }));
  BOOST_OUTCOME_TRYV(load_duplicates(entries));
  current_ = std::make_shared<const LiveVersion>(0, partition_, std::move(tiles), IdTiles().with(std::move(entries)));
  if (memory_with(*current()) > options_.memory_bytes) return too_little_memory();
  return success();
}

Status LiveResult::load_duplicates(std::vector<IdTiles::Entry>& entries) {
  const Manifest& manifest = source_.manifest();
  rows_.set_complete(!manifest.schema.empty());
  if (manifest.duplicates_xxh3 == 0) return success();
  BOOST_OUTCOME_TRY(pairs, read_duplicates(source_.folder(), manifest));
  BOOST_OUTCOME_TRY(rows, DuplicateRows::open(source_.folder(), manifest));
  rows_.set_complete(rows.has_value());
  duplicates_ = LiveDuplicates(pairs);
  const IdTiles vertices = IdTiles().with(entries);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto tile = vertices.find(pairs[i].kept);
    if (!tile)
      return error(Errc::corrupt, source_.folder().string() + ": point " + to_string(pairs[i].duplicate) +
                                      " is a duplicate of point " + to_string(pairs[i].kept) + ", which is no vertex");
    entries.emplace_back(pairs[i].duplicate, *tile);
    if (rows) rows_.add_stored(pairs[i].duplicate, rows->row(i));
  }
  return success();
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

LivePlanner LiveResult::planner(const LiveVersion& before) {
  return LivePlanner({source_, before, duplicates_, rows_, *stored_rows_, next_id_});
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

std::shared_ptr<const LiveVersion> LiveResult::next(const LiveVersion& before, const LivePlan& plan,
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
                                             before.ids().with(plan.entries));
}

// The bytes of `next`, of duplicates and attributes, and of the tiles of older versions that readers have; those that
// versions share count once. The
// version before `next` counts from the following batch on: its readers are mostly just about to take the new one.
std::size_t LiveResult::memory_with(const LiveVersion& next) {
  std::size_t bytes = next.memory() + duplicates_.memory() + rows_.memory(row_bytes(source_.manifest().schema));
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
void LiveResult::note(const LivePlan& plan, const ResultChange& change) {
  for (const PointId id : plan.duplicates_removed) duplicates_.remove(id);
  for (const auto& [vertex, heir] : plan.heirs) {
    duplicates_.inherit(vertex, heir);
    rows_.promote(heir);
  }
  for (const auto& [vertex, row] : plan.replaced) {
    duplicates_.add(vertex, plan.heirs.at(vertex));
    if (!row.empty()) rows_.add(vertex, row);
  }
  for (const DuplicatePair& pair : plan.duplicates) duplicates_.add(pair.duplicate, pair.kept);
  const std::size_t width = row_bytes(source_.manifest().schema);
  for (std::size_t i = 0; width > 0 && i < change.add.size(); ++i)
    rows_.add(PointId{next_id_ + i}, std::span(change.rows).subspan(i * width, width));
  for (const PointId id : plan.removed) rows_.remove(id);
  filtered_ += plan.removed.size();
  next_id_ += change.add.size();
}

Result<LiveApplied> LiveResult::apply(const ResultChange& change, EqualToNew equal) {
  const std::lock_guard lock(writer_);
  if (broken_) return *broken_;
  const std::uint64_t records = log_->records();
  try {
    BOOST_OUTCOME_TRYV(check_points(change));
    auto applied = equal == EqualToNew::go ? apply_logged(planner(*current()).with_equal_removed(change), true)
                                           : apply_logged(change, true);
    publish_state();
    return applied;
  } catch (const std::bad_alloc&) {
    return no_memory_since(records);
  }
}

// When the log has grown meanwhile, what is in memory is behind it.
Error LiveResult::no_memory_since(std::uint64_t records) {
  Error failed = worded([] { return error(Errc::memory, "no memory is left to change a result"); });
  if (log_ && log_->records() == records) return failed;
  broken_ = failed;
  publish_state();
  return failed;
}

// A record of which it is known that it is not in the log has changed nothing.
Status LiveResult::append(const ResultChange& change) {
  const Status written = log_->append(next_id_, change);
  if (written) return success();
  if (log_->intact()) return error(written.error().code, written.error().where + "; nothing has changed");
  broken_ = error(written.error().code, written.error().where + "; " + until_opened_again);
  return *broken_;
}

Result<LiveApplied> LiveResult::apply_logged(const ResultChange& change, bool log) {
  const auto before = current();
  LiveApplied applied{.version = before->number(), .first_new = next_id_};
  if (change.add.empty() && change.remove.empty()) return applied;
  BOOST_OUTCOME_TRY(plan, planner(*before).plan(change));
  applied.removed = plan.removed.size();
  LiveExchange exchange(*before, around_, plan.batch, options_.threads);
  BOOST_OUTCOME_TRYV(exchange.run());
  BOOST_OUTCOME_TRYV(check_left(*before, exchange));
  for (const auto& [id, tile] : exchange.tiles()) {
    applied.begun += tile.change.begins ? 1 : 0;
    ++applied.awake;
    for (const auto& [duplicate, kept] : tile.change.duplicates) {
      plan.duplicates.push_back({duplicate, kept});
      plan.equal.push_back(duplicate);
    }
    Bounds box = tile.triangulation->changed();
    if (const auto removed = plan.removed_of.find(id); removed != plan.removed_of.end()) box.add(removed->second);
    if (!box.empty()) applied.changed.push_back(box);
  }
  std::sort(plan.equal.begin(), plan.equal.end());
  applied.equal = plan.equal;
  std::set<TileId> changed;
  const auto version = next(*before, plan, exchange, changed);
  if (memory_with(*version) > options_.memory_bytes)
    return error(Errc::memory, source_.folder().string() + ": its tiles would need more than " +
                                   megabytes(options_.memory_bytes) +
                                   " in memory, with those of older versions that are still read");
  applied.version = version->number();
  if (log) {
    BOOST_OUTCOME_TRYV(append(change));
  }
  note(plan, change);
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
