// How the newest version of a live result is written.
#include <algorithm>
#include <exception>
#include <new>
#include <string>

#include "src/base/files/folder.h"
#include "src/base/files/linked_file.h"
#include "src/base/files/temporary.h"
#include "src/base/files/there.h"
#include "src/base/files/update_names.h"
#include "src/base/files/whole_file.h"
#include "src/delaunay/live/live_result.h"
#include "src/delaunay/live/live_split.h"
#include "src/delaunay/live/live_writer.h"
#include "src/delaunay/update/grown_tiles.h"
#include "src/delaunay/update/known_in_change.h"
#include "src/result/measure/hull_volume.h"
#include "src/result/new_version.h"

namespace tessera {

namespace fs = std::filesystem;

// The digest is known before the version is made, as the sum of those of its tiles. `other`: the tiles that have other
// files, or none.
std::optional<Digest> LiveResult::digest_with(const std::vector<TileEntry>& written,
                                              const std::set<TileId>& other) const {
  Digest sum;
  bool known = true;
  const auto add = [&](const TileEntry& entry) {
    known &= entry.digest.has_value();
    sum += entry.digest.value_or(Digest{});
  };
  for (std::size_t i = 0; i < source_.tiles(); ++i) {
    if (!other.contains(source_.entry(i).tile)) add(source_.entry(i));
  }
  for (const TileEntry& entry : written) add(entry);
  return known ? std::optional(sum) : std::nullopt;
}

// The files that were written to `folder`, with columns if the result has any. These come in a folder of their own, and
// unchanged tiles with values of vertices of changed ones, too.
Result<FinishedTiles> LiveResult::finish_tiles(const fs::path& folder, const std::vector<TileEntry>& written,
                                               const fs::path& columns) const {
  std::map<TileId, TileEntry> entries;
  std::set<TileId> gone = changed_;
  FinishedTiles plain;
  for (const TileEntry& entry : written) {
    entries[entry.tile] = entry;
    gone.erase(entry.tile);
    plain.tiles.push_back({entry, tile_file(folder, entry)});
  }
  if (whole_.manifest().columns.empty()) return plain;
  ChangedColumns::Change change{entries, std::move(gone), duplicates_.pairs()};
  return ChangedColumns(whole_, folder, std::move(change), columns, {}).make(options_.threads);
}

std::uint64_t LiveResult::tile_limit() const {
  return limit_of_tiles(source_.manifest(), options_.tile_points, grown_live_tile_least);
}

// The tiles of all points that are there.
IdTiles LiveResult::ids_of(const LiveVersion::Tiles& tiles) const {
  std::vector<IdTiles::Entry> entries;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    if (!tiles[i]) continue;
    for (const LocalPoint& p : tiles[i]->triangulation().own()) {
      const TileId tile{static_cast<std::uint32_t>(i)};
      entries.emplace_back(p.id, tile);
      const auto* also = duplicates_.of(p.id);
      for (const PointId duplicate : also ? *also : std::set<PointId>()) entries.emplace_back(duplicate, tile);
    }
  }
  return IdTiles().with(std::move(entries));
}

// The newest version as it is, unless tiles have grown too large, or removed points take up most of the list of ids.
Result<LiveResult::Storing> LiveResult::storing() {
  const auto now = current();
  Storing out{now, partition_, changed_};
  BOOST_OUTCOME_TRY(split, split_grown(*now, changed_, tile_limit(), around_));
  const std::uint64_t points = now->vertices() + duplicates_.size();
  if (!split && now->ids().size() <= 2 * points + 1000) return out;
  const auto& tiles = split ? split->tiles : now->tiles();
  const auto& partition = split ? split->partition : partition_;
  auto other = std::make_shared<const LiveVersion>(now->number(), partition, tiles, ids_of(tiles));
  if (split && memory_with(*other) > options_.memory_bytes) return out;
  out.version = std::move(other);
  out.partition = partition;
  if (split) out.tiles.insert(split->concerned.begin(), split->concerned.end());
  return out;
}

Status LiveResult::checkpoint() {
  const std::lock_guard lock(writer_);
  if (broken_) return *broken_;
  if (next_id_ == source_.manifest().points_read && filtered_ == 0) return success();
  const std::uint64_t records = log_->records();
  try {
    return store();
  } catch (const std::bad_alloc&) {
    return no_memory_since(records);
  } catch (const std::exception& failed) {
    if (!log_ || log_->records() != records) broken_ = error(Errc::internal, failed.what());
    throw;
  }
}

Status LiveResult::store() {
  BOOST_OUTCOME_TRY(next, NewVersion::begin(source_.folder(), {.has_log = true}));
  if (next->source().manifest().version != source_.manifest().version)
    return refuse("another program has changed the result while it was kept in memory");
  BOOST_OUTCOME_TRYV(make_directories(tiles_folder(next->scratch())));
  BOOST_OUTCOME_TRY(stored, storing());
  const LiveVersion& version = *stored.version;
  LiveWriter writer(source_, *partition_, version, rows_);
  BOOST_OUTCOME_TRY(written, writer.write(stored.tiles, next->scratch(), options_.threads));
  for (std::size_t i = 0; i < source_.tiles(); ++i) {
    const TileId tile = source_.entry(i).tile;
    if (stored.tiles.contains(tile) && !version.tiles()[tile.value]) next->remove_tile(i);
  }
  BOOST_OUTCOME_TRY(finished, finish_tiles(next->scratch(), written, update_columns_folder(next->scratch())));
  for (const auto& [entry, file] : finished.tiles) {
    const auto index = source_.find(entry.tile);
    BOOST_OUTCOME_TRYV(index ? next->replace_tile(*index, entry, file) : next->add_tile(entry, file));
  }
  next->manifest().format_version = updated_format;
  describe(next->manifest(), version);
  if (finished.hull_changed) {
    BOOST_OUTCOME_TRYV(renew_totals(next->draft(), next->manifest().columns, {}));
  }
  BOOST_OUTCOME_TRY(rows, rows_of_duplicates(next->scratch()));
  BOOST_OUTCOME_TRYV(next->replace_duplicates(duplicates_.pairs(), rows ? &*rows : nullptr));
  const auto digest = digest_with(written, stored.tiles);
  const std::uint64_t added = next_id_ - source_.manifest().points_read;
  Status done = digest ? log_->note_version(next->number(), *digest) : success();
  if (done) done = next->commit({}, {.added = added, .removed = filtered_});
  next.reset();
  if (done) done = begin_again(stored);
  if (!done) broken_ = error(done.error().code, done.error().where + "; " + until_opened_again);
  publish_state();
  return done;
}

// The attributes of all duplicates; nothing when some are not known, because software that did not keep them has made
// the result.
Result<std::optional<DuplicateRowSort>> LiveResult::rows_of_duplicates(const fs::path& scratch) const {
  constexpr std::uint64_t sort_bytes = std::uint64_t{64} << 20;
  const std::size_t width = row_bytes(source_.manifest().schema);
  std::optional<DuplicateRowSort> rows;
  if (!rows_.complete() || width == 0) return rows;
  const auto pairs = duplicates_.pairs();
  if (pairs.empty()) return rows;
  rows.emplace(scratch, sort_bytes, width);
  for (const DuplicatePair& pair : pairs) {
    const auto* row = rows_.find(pair.duplicate);
    if (!row)
      return error(Errc::internal, "the attributes of duplicate " + to_string(pair.duplicate) + " are not known");
    BOOST_OUTCOME_TRYV(rows->push(pair.duplicate, *row));
  }
  return rows;
}

// After the newest version was stored: with a log of its own, which has nothing yet.
Status LiveResult::begin_again(const Storing& stored) {
  const fs::path& out = source_.folder();
  BOOST_OUTCOME_TRY(whole, TileSource::open(out));
  const TileSource source = whole.without_columns();  // the log has no columns
  log_.reset();
  const auto begin = [&](std::uint64_t) { stored_number_ = current()->number(); };
  BOOST_OUTCOME_TRY(log,
                    LiveLog::open(out, source.manifest(), begin, [&](std::uint64_t, const ResultChange&) -> Status {
                      return error(Errc::corrupt, out.string() + ": the log of the new version is not empty");
                    }));
  log_.emplace(std::move(log));
  whole_ = std::move(whole);
  source_ = source;
  stored_rows_.emplace(source_);
  changed_.clear();
  rows_.store(duplicates_.pairs());
  filtered_ = 0;
  if (stored.version == current()) return success();
  if (stored.partition != partition_) around_ = known_in_change(*stored.partition);
  partition_ = stored.partition;
  older_.push_back(current());
  current_ = stored.version;
  return success();
}

Result<Manifest> LiveResult::write_to(const fs::path& to) const {
  const std::lock_guard lock(writer_);
  BOOST_OUTCOME_TRY(there, is_there(to));
  if (there) return error(Errc::usage, to.string() + ": exists already");
  BOOST_OUTCOME_TRY(folder, TemporaryFolder::make(temporary_name_of_process(to)));
  BOOST_OUTCOME_TRYV(make_directories(tiles_folder(folder.path())));
  const auto version = current();
  // Columns come with the second version of a result at the earliest.
  Manifest manifest = whole_.manifest();
  manifest.version = manifest.columns.empty() ? 1 : 2;
  for (ResultColumn& column : manifest.columns) column.version = manifest.version;
  manifest.previous_master_xxh3.reset();
  LiveWriter writer(source_, *partition_, *version, rows_);
  BOOST_OUTCOME_TRY(written, writer.write(changed_, folder.path(), options_.threads));
  const fs::path made = manifest.columns.empty() ? folder.path() : update_columns_folder(folder.path());
  BOOST_OUTCOME_TRY(finished, finish_tiles(folder.path(), written, made));
  manifest.tiles.clear();
  std::set<TileId> other = changed_;
  for (const auto& [entry, file] : finished.tiles) {
    other.insert(entry.tile);
    manifest.tiles.push_back(entry);
    manifest.tiles.back().version = 1;
  }
  for (std::size_t i = 0; i < source_.tiles(); ++i) {
    TileEntry entry = source_.entry(i);
    if (other.contains(entry.tile)) continue;
    entry.version = 1;
    BOOST_OUTCOME_TRYV(link_or_copy(source_.file(i), tile_file(made, entry)));
    manifest.tiles.push_back(entry);
  }
  describe(manifest, *version);
  if (finished.hull_changed) {
    BOOST_OUTCOME_TRYV(renew_totals(TileSource::draft(made, manifest), manifest.columns, {}));
  }
  BOOST_OUTCOME_TRY(rows, rows_of_duplicates(folder.path()));
  BOOST_OUTCOME_TRYV(finish_store(made, manifest, duplicates_.pairs(), rows ? &*rows : nullptr));
  BOOST_OUTCOME_TRYV(rename_file(made, to));
  if (made == folder.path()) folder.keep();
  return manifest;
}

// Removed points count as filtered: they were read, and no vertex stands for them.
void LiveResult::describe(Manifest& manifest, const LiveVersion& version) const {
  std::sort(manifest.tiles.begin(), manifest.tiles.end(),
            [](const TileEntry& a, const TileEntry& b) { return a.tile < b.tile; });
  manifest.bounds = {};
  for (const auto& tile : version.tiles()) {
    if (!tile) continue;
    for (const LocalPoint& p : tile->triangulation().own()) manifest.bounds.add(p.at);
  }
  manifest.boxes = version.partition().boxes();
  manifest.partition = remember_limit(version.partition().to_json(), tile_limit());
  manifest.points_read = next_id_;
  manifest.filtered += filtered_;
  manifest.vertices = manifest.cells = 0;
  for (const TileEntry& entry : manifest.tiles) {
    manifest.vertices += entry.own_points;
    manifest.cells += entry.main_cells;
  }
  manifest.seconds.clear();
  manifest.figures.clear();
  if (!changed_.empty()) manifest.other_heights.reset();  // results do not keep the heights of duplicates
}

}  // namespace tessera
