#include "src/delaunay/update/updated_result.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "src/base/files/whole_file.h"
#include "src/base/on_threads.h"
#include "src/base/stopped.h"
#include "src/result/store/digest.h"
#include "src/result/store/points_tile.h"
#include "src/tiling/hilbert.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

constexpr std::uint64_t rows_bytes = std::uint64_t{64} << 20;  // for sorting the attributes of duplicates

// Makes a hard link, or a copy where the file system has no hard links.
Status link_or_copy(const fs::path& from, const fs::path& to) {
  if (::link(from.c_str(), to.c_str()) == 0) return success();
  BOOST_OUTCOME_TRY(bytes, read_whole(from));
  return write_whole(to, bytes);
}

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

// A tile without a file gets one like the others.
TileKind UpdatedResult::kind_of(TileId tile) const {
  if (const auto index = setting_.source.find(tile)) return setting_.source.entry(*index).kind;
  const auto& all = setting_.source.manifest().tiles;
  const bool points = std::all_of(all.begin(), all.end(), [](const auto& e) { return e.kind == TileKind::points; });
  return points ? TileKind::points : TileKind::cells;
}

// A foreign vertex that is new to a tile is a vertex of changed cells, so its owner was awake.
Result<std::vector<std::byte>> UpdatedResult::rows_of(const TileMesh& mesh, TileId tile) const {
  const std::size_t width = row_bytes(setting_.source.manifest().schema);
  std::vector<std::byte> rows(mesh.ids.size() * width);
  for (std::size_t v = 0; v < mesh.ids.size() && width > 0; ++v) {
    auto row = tiles_.at(tile)->row(mesh.ids[v]);
    const auto owner = tiles_.find(mesh.owners[v]);
    if (!row && owner != tiles_.end()) row = owner->second->row(mesh.ids[v]);
    if (!row) return error(Errc::internal, "the attributes of point " + to_string(mesh.ids[v]) + " are not known");
    std::memcpy(&rows[v * width], row->data(), width);
  }
  return rows;
}

Result<TileEntry> UpdatedResult::write_as_points(TileId tile, const TileMesh& mesh,
                                                 const std::vector<std::byte>& rows) {
  const Manifest& manifest = setting_.source.manifest();
  const auto own = static_cast<std::size_t>(std::count(mesh.point_ghost.begin(), mesh.point_ghost.end(), 0));
  Bounds bounds;
  for (std::size_t v = own; v < mesh.points.size(); ++v) bounds.add(mesh.points[v]);
  const HilbertKey key(bounds, manifest.dimension);
  std::vector<std::size_t> order(mesh.points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin() + static_cast<std::ptrdiff_t>(own), order.end(), [&](std::size_t a, std::size_t b) {
    return std::pair(key(mesh.points[a]), mesh.ids[a]) < std::pair(key(mesh.points[b]), mesh.ids[b]);
  });
  std::vector<Point> points;
  std::vector<PointId> ids;
  std::vector<TileId> owners;
  std::vector<std::byte> ordered(rows.size());
  const std::size_t width = row_bytes(manifest.schema);
  for (const std::size_t v : order) {
    if (width > 0) std::memcpy(&ordered[points.size() * width], &rows[v * width], width);
    points.push_back(mesh.points[v]);
    ids.push_back(mesh.ids[v]);
    owners.push_back(mesh.owners[v]);
  }
  CountedCells counted;
  counted.cells = mesh.cell_ghost.size();
  counted.main_cells = static_cast<std::uint64_t>(std::count(mesh.cell_ghost.begin(), mesh.cell_ghost.end(), 0));
  counted.digest = CellDigest(manifest.dimension, mesh.ids).of(mesh.cells, mesh.cell_ghost.data());
  return write_points_tile(folder_,
                           {.dimension = manifest.dimension,
                            .tile = tile,
                            .own = own,
                            .points = points,
                            .ids = ids,
                            .owners = owners,
                            .schema = manifest.schema,
                            .rows = ordered},
                           counted, {.schema = manifest.schema, .stop = setting_.stop});
}

Status UpdatedResult::write(TileId tile, WokenTile& woken) {
  throw_if_stopped(setting_.stop);
  const Manifest& manifest = setting_.source.manifest();
  const TileMesh mesh = woken.collect();
  BOOST_OUTCOME_TRY(rows, rows_of(mesh, tile));
  const StoreOptions options{.neighbors = manifest.neighbors, .schema = manifest.schema, .stop = setting_.stop};
  BOOST_OUTCOME_TRY(entry, kind_of(tile) == TileKind::points ? write_as_points(tile, mesh, rows)
                                                             : write_tile(folder_, tile, mesh, rows, options));
  const std::lock_guard lock(mutex_);
  written_[tile] = entry;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    if (mesh.point_ghost[v] == 0) written_bounds_.add(mesh.points[v]);
  }
  return success();
}

Status UpdatedResult::write_changed(unsigned threads) {
  std::vector<TileId> changed;
  for (const auto& [id, tile] : tiles_) {
    if (tile->awake() && tile->changed()) changed.push_back(id);
  }
  std::atomic<bool> failed{false};
  std::atomic<std::size_t> next{0};
  return on_threads(threads, failed, [&]() -> Status {
    for (std::size_t i = next++; i < changed.size() && !failed; i = next++) {
      BOOST_OUTCOME_TRYV(write(changed[i], *tiles_.at(changed[i])));
    }
    return success();
  });
}

// A tile that has lost all its points, or whose cells were written anew.
bool UpdatedResult::is_gone(TileId tile) const {
  const auto woken = tiles_.find(tile);
  return written_.contains(tile) || (woken != tiles_.end() && woken->second->lost());
}

Status UpdatedResult::link_others() {
  manifest_ = setting_.source.manifest();
  manifest_.tiles.clear();
  for (std::size_t i = 0; i < setting_.source.tiles(); ++i) {
    TileEntry entry = setting_.source.entry(i);
    if (is_gone(entry.tile)) continue;
    entry.version = 1;
    BOOST_OUTCOME_TRYV(link_or_copy(setting_.source.file(i), tile_file(folder_, entry)));
    manifest_.tiles.push_back(entry);
  }
  for (const auto& [tile, entry] : written_) manifest_.tiles.push_back(entry);
  return success();
}

// The bounds can only shrink when a vertex goes that lies on them. Then tiles are read whose boxes reach beyond what is
// known of the bounds, the outermost first: mostly those along one side.
Result<Bounds> UpdatedResult::bounds() const {
  const TileSource& source = setting_.source;
  const Manifest& old = source.manifest();
  Bounds removed;
  for (const auto& [id, tile] : tiles_) removed.add(tile->removed_bounds());
  Bounds known = known_bounds(written_bounds_, removed, old.bounds, old.dimension);
  if (!touches(removed, old.bounds, old.dimension)) return known;
  const auto box_of = [&](std::size_t i) {
    const std::size_t tile = source.entry(i).tile.value;
    return tile < old.boxes.size() ? old.boxes[tile] : Box{};
  };
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < source.tiles(); ++i) {
    if (!is_gone(source.entry(i).tile)) order.emplace_back(depth_in(box_of(i), old.bounds, old.dimension), i);
  }
  std::sort(order.begin(), order.end());
  for (const auto& [depth, i] : order) {
    if (!may_widen(box_of(i), old.bounds, known, old.dimension)) continue;
    throw_if_stopped(setting_.stop);
    BOOST_OUTCOME_TRY(stored, source.read(i, {.cells = false}));
    for (std::size_t v = 0; v < stored.mesh.points.size(); ++v) {
      if (stored.mesh.point_ghost[v] == 0) known.add(stored.mesh.points[v]);
    }
  }
  return known;
}

// Removed points count as filtered: they were read, and no vertex stands for them.
void UpdatedResult::describe(Manifest& manifest, const ResultChange& change, const UpdateOptions& options) const {
  if (!options.command.empty()) manifest.command = options.command;
  if (!options.software_version.empty()) manifest.software_version = options.software_version;
  manifest.inputs.insert(manifest.inputs.end(), options.inputs.begin(), options.inputs.end());
  manifest.points_read += change.add.size();
  manifest.filtered += setting_.plan.removed_points;
  manifest.seconds.clear();
  manifest.figures.clear();
  if (duplicates_changed()) manifest.other_heights.reset();  // results do not keep the heights of duplicates
}

bool UpdatedResult::duplicates_changed() const {
  return setting_.plan.duplicates_changed ||
         std::any_of(tiles_.begin(), tiles_.end(), [](const auto& tile) { return !tile.second->duplicates().empty(); });
}

std::vector<DuplicatePair> UpdatedResult::duplicates() const {
  std::vector<DuplicatePair> duplicates = setting_.plan.duplicates;
  for (const auto& [id, tile] : tiles_)
    duplicates.insert(duplicates.end(), tile->duplicates().begin(), tile->duplicates().end());
  std::sort(duplicates.begin(), duplicates.end());
  return duplicates;
}

Status UpdatedResult::finish(const ResultChange& change, const UpdateOptions& options) {
  BOOST_OUTCOME_TRY(box, bounds());
  manifest_.bounds = box;
  manifest_.version = 1;
  manifest_.previous_master_xxh3.reset();
  describe(manifest_, change, options);
  manifest_.vertices = manifest_.cells = 0;
  for (const TileEntry& entry : manifest_.tiles) {
    manifest_.vertices += entry.own_points;
    manifest_.cells += entry.main_cells;
  }
  return finish_store(folder_, manifest_, duplicates());
}

// With the columns of the result, if it has any.
Result<std::vector<FinishedTile>> UpdatedResult::finished_tiles(const NewVersion& version, unsigned threads) const {
  if (!version.source().manifest().columns.empty())
    return ChangedColumns(version.source(), folder_, written_, setting_.stop).make(threads);
  std::vector<FinishedTile> finished;
  for (const auto& [tile, entry] : written_) finished.push_back({entry, tile_file(folder_, entry)});
  return finished;
}

Status UpdatedResult::commit(NewVersion& version, const ResultChange& change, const UpdateOptions& options) {
  BOOST_OUTCOME_TRY(box, bounds());
  Manifest& manifest = version.manifest();
  manifest.format_version = updated_format;
  manifest.bounds = box;
  describe(manifest, change, options);
  for (std::size_t i = 0; i < setting_.source.tiles(); ++i) {
    const TileId tile = setting_.source.entry(i).tile;
    if (is_gone(tile) && !written_.contains(tile)) version.remove_tile(i);
  }
  BOOST_OUTCOME_TRY(finished, finished_tiles(version, options.threads));
  for (const auto& [entry, file] : finished) {
    const auto index = setting_.source.find(entry.tile);
    BOOST_OUTCOME_TRYV(index ? version.replace_tile(*index, entry, file) : version.add_tile(entry, file));
  }
  for (ResultColumn& column : manifest.columns) column.total.reset();  // which only a pass over all tiles tells
  if (duplicates_changed()) {
    BOOST_OUTCOME_TRYV(version.replace_duplicates(duplicates()));
  }
  return version.commit({}, {.added = change.add.size(),
                             .removed = setting_.plan.removed_points,
                             .inputs = options.inputs,
                             .command = options.command,
                             .software_version = options.software_version});
}

}  // namespace tessera
