// How the newest version of a live result is written.
#include <algorithm>
#include <atomic>
#include <cstring>
#include <numeric>
#include <string>

#include "src/base/files/folder.h"
#include "src/base/files/linked_file.h"
#include "src/base/files/temporary.h"
#include "src/base/files/there.h"
#include "src/base/files/update_names.h"
#include "src/base/files/whole_file.h"
#include "src/base/on_threads.h"
#include "src/delaunay/live/live_result.h"
#include "src/delaunay/live/live_writer.h"
#include "src/result/measure/hull_volume.h"
#include "src/result/new_version.h"

namespace tessera {

namespace fs = std::filesystem;

// The digest is known before the version is made, as the sum of those of its tiles.
std::optional<Digest> LiveResult::digest_with(const std::vector<TileEntry>& written) const {
  Digest sum;
  bool known = true;
  const auto add = [&](const TileEntry& entry) {
    known &= entry.digest.has_value();
    sum += entry.digest.value_or(Digest{});
  };
  for (std::size_t i = 0; i < source_.tiles(); ++i) {
    if (!changed_.contains(source_.entry(i).tile)) add(source_.entry(i));
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

Status LiveResult::checkpoint() {
  const std::lock_guard lock(writer_);
  if (broken_) return *broken_;
  if (next_id_ == source_.manifest().points_read && filtered_ == 0) return success();
  BOOST_OUTCOME_TRY(next, NewVersion::begin(source_.folder()));
  if (next->source().manifest().version != source_.manifest().version)
    return refuse("another program has changed the result while it was kept in memory");
  BOOST_OUTCOME_TRYV(make_directories(tiles_folder(next->scratch())));
  const auto version = current();
  LiveWriter writer(source_, *version, rows_);
  BOOST_OUTCOME_TRY(written, writer.write(changed_, next->scratch(), options_.threads));
  for (std::size_t i = 0; i < source_.tiles(); ++i) {
    const TileId tile = source_.entry(i).tile;
    if (changed_.contains(tile) && !version->tiles()[tile.value]) next->remove_tile(i);
  }
  BOOST_OUTCOME_TRY(finished, finish_tiles(next->scratch(), written, update_columns_folder(next->scratch())));
  for (const auto& [entry, file] : finished.tiles) {
    const auto index = source_.find(entry.tile);
    BOOST_OUTCOME_TRYV(index ? next->replace_tile(*index, entry, file) : next->add_tile(entry, file));
  }
  next->manifest().format_version = updated_format;
  describe(next->manifest(), *version);
  if (finished.hull_changed) {
    BOOST_OUTCOME_TRYV(renew_totals(next->draft(), next->manifest().columns, {}));
  }
  BOOST_OUTCOME_TRY(rows, rows_of_duplicates(next->scratch()));
  BOOST_OUTCOME_TRYV(next->replace_duplicates(duplicates_.pairs(), rows ? &*rows : nullptr));
  const auto digest = digest_with(written);
  const std::uint64_t added = next_id_ - source_.manifest().points_read;
  Status done = digest ? log_->note_version(next->number(), *digest) : success();
  if (done) done = next->commit({}, {.added = added, .removed = filtered_});
  next.reset();
  if (done) done = begin_again();
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
  if (!duplicates_have_rows_ || width == 0) return rows;
  const auto pairs = duplicates_.pairs();
  if (pairs.empty()) return rows;
  rows.emplace(scratch, sort_bytes, width);
  for (const DuplicatePair& pair : pairs) {
    const auto* row = row_of_duplicate(pair.duplicate);
    if (!row)
      return error(Errc::internal, "the attributes of duplicate " + to_string(pair.duplicate) + " are not known");
    BOOST_OUTCOME_TRYV(rows->push(pair.duplicate, *row));
  }
  return rows;
}

// After the newest version was stored: with a log of its own, which has nothing yet.
Status LiveResult::begin_again() {
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
  changed_.clear();
  // Without rows of all duplicates none are stored, and the result opened again must refuse what this one refuses.
  for (const DuplicatePair& pair : duplicates_have_rows_ ? duplicates_.pairs() : std::vector<DuplicatePair>{}) {
    if (auto row = rows_.extract(pair.duplicate)) duplicate_rows_.insert(std::move(row));
  }
  rows_.clear();
  filtered_ = 0;
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
  LiveWriter writer(source_, *version, rows_);
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
