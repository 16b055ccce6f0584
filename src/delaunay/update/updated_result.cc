#include "src/delaunay/update/updated_result.h"

#include <algorithm>
#include <limits>
#include <set>
#include <utility>

#include "src/base/files/linked_file.h"
#include "src/base/stopped.h"
#include "src/delaunay/update/changed_columns.h"
#include "src/delaunay/update/grown_tiles.h"
#include "src/result/measure/hull_volume.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

constexpr std::uint64_t rows_bytes = std::uint64_t{64} << 20;  // for sorting the attributes of duplicates

bool touches(const Bounds& inner, const Bounds& outer, int dimension) {
  if (inner.empty()) return false;
  for (int axis = 0; axis < dimension; ++axis) {
    if (inner.lo[axis] <= outer.lo[axis] || inner.hi[axis] >= outer.hi[axis]) return true;
  }
  return false;
}

// Bounds that are known before a tile is read: those of the vertices that were written, and the old ones at all sides
// from which no vertex has gone.
Bounds known_bounds(const Bounds& written, const Bounds& removed, const Bounds& old, int dimension) {
  Bounds known = written;
  for (int axis = 0; axis < 3; ++axis) {
    if (axis >= dimension || removed.lo[axis] > old.lo[axis]) known.lo[axis] = std::min(known.lo[axis], old.lo[axis]);
    if (axis >= dimension || removed.hi[axis] < old.hi[axis]) known.hi[axis] = std::max(known.hi[axis], old.hi[axis]);
  }
  return known;
}

// How far the vertices of a tile are at least from the nearest side of the old bounds.
double depth_in(const Box& box, const Bounds& old, int dimension) {
  double least = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < dimension; ++axis)
    least = std::min({least, std::max(0.0, box.lo[axis] - old.lo[axis]), std::max(0.0, old.hi[axis] - box.hi[axis])});
  return least;
}

// Whether a vertex in the box could lie beyond the bounds that are known.
bool may_widen(const Box& box, const Bounds& old, const Bounds& known, int dimension) {
  for (int axis = 0; axis < dimension; ++axis) {
    if (std::max(box.lo[axis], old.lo[axis]) < known.lo[axis]) return true;
    if (std::min(box.hi[axis], old.hi[axis]) > known.hi[axis]) return true;
  }
  return false;
}

}  // namespace

Status UpdatedResult::link_others() {
  manifest_ = whole_.manifest();
  manifest_.tiles.clear();
  BOOST_OUTCOME_TRY(finished, finished_tiles(duplicates()));
  std::set<TileId> written;
  hull_changed_ = finished.hull_changed;
  for (const auto& [entry, file] : finished.tiles) {
    written.insert(entry.tile);
    manifest_.tiles.push_back(entry);
    manifest_.tiles.back().version = 1;
  }
  for (std::size_t i = 0; i < source_.tiles(); ++i) {
    TileEntry entry = source_.entry(i);
    if (is_other(entry.tile) || written.contains(entry.tile)) continue;
    entry.version = 1;
    BOOST_OUTCOME_TRYV(link_or_copy(source_.file(i), tile_file(target(), entry)));
    manifest_.tiles.push_back(entry);
  }
  std::sort(manifest_.tiles.begin(), manifest_.tiles.end(),
            [](const TileEntry& a, const TileEntry& b) { return a.tile < b.tile; });
  return success();
}

bool UpdatedResult::is_other(TileId tile) const {
  const auto end = ends_.find(tile);
  return end != ends_.end() && end->second.changed;
}

// The bounds can only shrink when a vertex goes that lies on them. Then tiles are read whose boxes reach beyond what is
// known of the bounds, the outermost first: mostly those along one side.
Result<Bounds> UpdatedResult::bounds() const {
  const Manifest& old = source_.manifest();
  Bounds written, removed;
  for (const auto& [tile, end] : ends_) {
    written.add(end.bounds);
    removed.add(end.removed_bounds);
  }
  Bounds known = known_bounds(written, removed, old.bounds, old.dimension);
  if (!touches(removed, old.bounds, old.dimension)) return known;
  const auto box_of = [&](std::size_t i) {
    const std::size_t tile = source_.entry(i).tile.value;
    return tile < old.boxes.size() ? old.boxes[tile] : Box{};
  };
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < source_.tiles(); ++i) {
    if (!is_other(source_.entry(i).tile)) order.emplace_back(depth_in(box_of(i), old.bounds, old.dimension), i);
  }
  std::sort(order.begin(), order.end());
  for (const auto& [depth, i] : order) {
    if (!may_widen(box_of(i), old.bounds, known, old.dimension)) continue;
    throw_if_stopped(stop_);
    BOOST_OUTCOME_TRY(stored, source_.read(i, {.cells = false}));
    for (std::size_t v = 0; v < stored.mesh.points.size(); ++v) {
      if (stored.mesh.point_ghost[v] == 0) known.add(stored.mesh.points[v]);
    }
  }
  return known;
}

// Removed points count as filtered: they were read, and no vertex stands for them.
void UpdatedResult::describe(Manifest& manifest) const {
  if (!options_.command.empty() && !options_.keep_command) manifest.command = options_.command;
  if (!options_.software_version.empty()) manifest.software_version = options_.software_version;
  const auto added = inputs();
  manifest.inputs.insert(manifest.inputs.end(), added.begin(), added.end());
  manifest.points_read += change_.add.size();
  manifest.filtered += plan_.removed_points;
  manifest.boxes = partition_.boxes();
  manifest.partition = remember_limit(partition_.to_json(), tile_points_);
  manifest.seconds.clear();
  manifest.figures.clear();
  if (duplicates_changed()) manifest.other_heights.reset();  // they are not counted again
}

std::vector<Manifest::Input> UpdatedResult::inputs() const {
  std::vector<Manifest::Input> inputs = options_.inputs;
  for (Manifest::Input& input : inputs) {
    if (input.ids) input.ids->first += plan_.first_new;
  }
  return inputs;
}

bool UpdatedResult::duplicates_changed() const {
  return plan_.duplicates_changed ||
         std::any_of(ends_.begin(), ends_.end(), [](const auto& tile) { return !tile.second.duplicates.empty(); });
}

std::vector<DuplicatePair> UpdatedResult::duplicates() const {
  std::vector<DuplicatePair> duplicates = plan_.duplicates;
  for (const auto& [tile, end] : ends_) {
    duplicates.insert(duplicates.end(), end.duplicates.begin(), end.duplicates.end());
  }
  std::sort(duplicates.begin(), duplicates.end());
  return duplicates;
}

// A result of older software may lack the attributes of some of the duplicates. Then the new one has none of them.
Status UpdatedResult::sort_rows(std::span<const DuplicatePair> duplicates,
                                std::optional<DuplicateRowSort>& rows) const {
  const std::size_t width = row_bytes(source_.manifest().schema);
  if (width == 0) return success();
  rows.emplace(folder_, rows_bytes, width, stop_);
  for (const DuplicatePair& pair : duplicates) {
    const std::uint64_t id = pair.duplicate.value, first_new = plan_.first_new;
    const auto row = id >= first_new ? std::optional(std::span(change_.rows).subspan((id - first_new) * width, width))
                                     : plan_.old.row(pair.duplicate);
    if (!row) {
      rows.reset();
      return success();
    }
    BOOST_OUTCOME_TRYV(rows->push(pair.duplicate, *row));
  }
  return success();
}

Status UpdatedResult::finish() {
  BOOST_OUTCOME_TRY(box, bounds());
  manifest_.bounds = box;
  // Columns come with the second version of a result at the earliest.
  manifest_.version = manifest_.columns.empty() ? 1 : 2;
  for (ResultColumn& column : manifest_.columns) column.version = manifest_.version;
  manifest_.previous_master_xxh3.reset();
  describe(manifest_);
  if (hull_changed_) {
    BOOST_OUTCOME_TRYV(renew_totals(TileSource::draft(target(), manifest_), manifest_.columns, stop_));
  }
  manifest_.vertices = manifest_.cells = 0;
  for (const TileEntry& entry : manifest_.tiles) {
    manifest_.vertices += entry.own_points;
    manifest_.cells += entry.main_cells;
  }
  const auto pairs = duplicates();
  std::optional<DuplicateRowSort> rows;
  BOOST_OUTCOME_TRYV(sort_rows(pairs, rows));
  return finish_store(target(), manifest_, pairs, rows ? &*rows : nullptr);
}

// With the columns of the result, if it has any.
Result<FinishedTiles> UpdatedResult::finished_tiles(std::span<const DuplicatePair> duplicates) const {
  std::map<TileId, TileEntry> written;
  std::set<TileId> gone;
  for (const auto& [tile, end] : ends_) {
    if (end.entry) written[tile] = *end.entry;
    if (end.changed && !end.entry) gone.insert(tile);
  }
  if (!whole_.manifest().columns.empty()) {
    ChangedColumns::Change change{written, std::move(gone), {duplicates.begin(), duplicates.end()}};
    return ChangedColumns(whole_, folder_, std::move(change), columns_, stop_).make(options_.threads);
  }
  FinishedTiles finished;
  for (const auto& [tile, entry] : written) finished.tiles.push_back({entry, tile_file(folder_, entry)});
  return finished;
}

Status UpdatedResult::commit(NewVersion& version, const std::function<Status(const std::string& manifest)>& before) {
  BOOST_OUTCOME_TRY(box, bounds());
  Manifest& manifest = version.manifest();
  manifest.format_version = updated_format;
  manifest.bounds = box;
  describe(manifest);
  for (std::size_t i = 0; i < source_.tiles(); ++i) {
    const auto end = ends_.find(source_.entry(i).tile);
    if (end != ends_.end() && end->second.changed && !end->second.entry) version.remove_tile(i);
  }
  const auto pairs = duplicates();
  BOOST_OUTCOME_TRY(finished, finished_tiles(pairs));
  for (const auto& [entry, file] : finished.tiles) {
    const auto index = source_.find(entry.tile);
    BOOST_OUTCOME_TRYV(index ? version.replace_tile(*index, entry, file) : version.add_tile(entry, file));
  }
  if (finished.hull_changed) {
    BOOST_OUTCOME_TRYV(renew_totals(version.draft(), manifest.columns, stop_));
  }
  if (duplicates_changed()) {
    std::optional<DuplicateRowSort> rows;
    BOOST_OUTCOME_TRYV(sort_rows(pairs, rows));
    BOOST_OUTCOME_TRYV(version.replace_duplicates(pairs, rows ? &*rows : nullptr));
  }
  return version.commit({},
                        {.added = change_.add.size(),
                         .removed = plan_.removed_points,
                         .inputs = inputs(),
                         .command = options_.command,
                         .software_version = options_.software_version},
                        before);
}

}  // namespace tessera
