#include "src/delaunay/update/updated_result.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstring>
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

Status UpdatedResult::link_others() {
  manifest_ = setting_.source.manifest();
  manifest_.tiles.clear();
  for (std::size_t i = 0; i < setting_.source.tiles(); ++i) {
    TileEntry entry = setting_.source.entry(i);
    const auto woken = tiles_.find(entry.tile);
    if (written_.contains(entry.tile) || (woken != tiles_.end() && woken->second->lost())) continue;
    entry.version = 1;
    BOOST_OUTCOME_TRYV(link_or_copy(setting_.source.file(i), tile_file(folder_, entry)));
    manifest_.tiles.push_back(entry);
  }
  for (const auto& [tile, entry] : written_) manifest_.tiles.push_back(entry);
  return success();
}

// The bounds can only shrink when a vertex goes that lies on them. Then all tiles are read.
Result<Bounds> UpdatedResult::bounds() const {
  const Manifest& old = setting_.source.manifest();
  Bounds bounds = written_bounds_, removed;
  for (const auto& [id, tile] : tiles_) removed.add(tile->removed_bounds());
  if (!touches(removed, old.bounds, old.dimension)) {
    bounds.add(old.bounds);
    return bounds;
  }
  for (std::size_t i = 0; i < setting_.source.tiles(); ++i) {
    const TileId tile = setting_.source.entry(i).tile;
    const auto woken = tiles_.find(tile);
    if (written_.contains(tile) || (woken != tiles_.end() && woken->second->lost())) continue;
    BOOST_OUTCOME_TRY(stored, setting_.source.read(i, {.cells = false}));
    for (std::size_t v = 0; v < stored.mesh.points.size(); ++v) {
      if (stored.mesh.point_ghost[v] == 0) bounds.add(stored.mesh.points[v]);
    }
  }
  return bounds;
}

// Removed points count as filtered: they were read, and no vertex stands for them.
Status UpdatedResult::finish(const ResultChange& change, const UpdateOptions& options) {
  BOOST_OUTCOME_TRY(box, bounds());
  manifest_.bounds = box;
  manifest_.version = 1;
  manifest_.previous_master_xxh3.reset();
  if (!options.command.empty()) manifest_.command = options.command;
  if (!options.software_version.empty()) manifest_.software_version = options.software_version;
  for (const Manifest::Input& input : options.inputs) {
    manifest_.inputs.push_back(input);
    if (input.ids) manifest_.inputs.back().ids->first += setting_.plan.first_new;
  }
  manifest_.points_read += change.add.size();
  manifest_.filtered += setting_.plan.removed_points;
  manifest_.vertices = manifest_.cells = 0;
  for (const TileEntry& entry : manifest_.tiles) {
    manifest_.vertices += entry.own_points;
    manifest_.cells += entry.main_cells;
  }
  manifest_.seconds.clear();
  manifest_.figures.clear();
  std::vector<DuplicatePair> duplicates = setting_.plan.duplicates;
  bool duplicates_changed = setting_.plan.duplicates_changed;
  for (const auto& [id, tile] : tiles_) {
    duplicates.insert(duplicates.end(), tile->duplicates().begin(), tile->duplicates().end());
    duplicates_changed |= !tile->duplicates().empty();
  }
  if (duplicates_changed) manifest_.other_heights.reset();  // they are not counted again
  std::sort(duplicates.begin(), duplicates.end());
  std::optional<DuplicateRowSort> rows;
  BOOST_OUTCOME_TRYV(sort_rows(duplicates, change.rows, rows));
  return finish_store(folder_, manifest_, duplicates, rows ? &*rows : nullptr);
}

// A result of older software may lack the attributes of some of the duplicates. Then the new one has none of them.
Status UpdatedResult::sort_rows(std::span<const DuplicatePair> duplicates, std::span<const std::byte> added,
                                std::optional<DuplicateRowSort>& rows) const {
  const std::size_t width = row_bytes(setting_.source.manifest().schema);
  if (width == 0) return success();
  rows.emplace(folder_, rows_bytes, width);
  for (const DuplicatePair& pair : duplicates) {
    const std::uint64_t id = pair.duplicate.value, first_new = setting_.plan.first_new;
    const auto row = id >= first_new ? std::optional(added.subspan((id - first_new) * width, width))
                                     : setting_.plan.old.row(pair.duplicate);
    if (!row) {
      rows.reset();
      return success();
    }
    BOOST_OUTCOME_TRYV(rows->push(pair.duplicate, *row));
  }
  return success();
}

}  // namespace tessera
