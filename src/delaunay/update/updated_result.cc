#include "src/delaunay/update/updated_result.h"

#include <unistd.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "src/base/files/whole_file.h"
#include "src/tiling/partition.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

// Makes a hard link, or a copy where the file system has no hard links. An earlier process may have made one.
Status link_or_copy(const fs::path& from, const fs::path& to) {
  BOOST_OUTCOME_TRYV(remove_file(to));
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

Status UpdatedResult::link_others() {
  manifest_ = source_.manifest();
  manifest_.tiles.clear();
  for (std::size_t i = 0; i < source_.tiles(); ++i) {
    TileEntry entry = source_.entry(i);
    if (is_other(entry.tile)) continue;
    entry.version = 1;
    BOOST_OUTCOME_TRYV(link_or_copy(source_.file(i), tile_file(folder_, entry)));
    manifest_.tiles.push_back(entry);
  }
  for (const auto& [tile, end] : ends_) {
    if (end.entry) manifest_.tiles.push_back(*end.entry);
  }
  std::sort(manifest_.tiles.begin(), manifest_.tiles.end(),
            [](const TileEntry& a, const TileEntry& b) { return a.tile < b.tile; });
  return success();
}

bool UpdatedResult::is_other(TileId tile) const {
  const auto end = ends_.find(tile);
  return end != ends_.end() && end->second.changed;
}

// The bounds can only shrink when a vertex goes that lies on them. Then the tiles are read that may have a vertex
// beyond what is known by then: those at the sides of the partition.
Result<Bounds> UpdatedResult::bounds() const {
  const Manifest& old = source_.manifest();
  Bounds bounds, removed;
  for (const auto& [tile, end] : ends_) {
    bounds.add(end.bounds);
    removed.add(end.removed_bounds);
  }
  if (!touches(removed, old.bounds, old.dimension)) {
    bounds.add(old.bounds);
    return bounds;
  }
  BOOST_OUTCOME_TRY(partition, Partition::from_json(old.partition));
  std::vector<std::size_t> unread;
  for (std::size_t i = 0; i < source_.tiles(); ++i) {
    if (!is_other(source_.entry(i).tile)) unread.push_back(i);
  }
  for (const std::size_t i : unread) {
    const Box& box = partition.boxes().at(source_.entry(i).tile.value);
    bool beyond = bounds.empty();
    for (int axis = 0; axis < old.dimension; ++axis) {
      // no vertex of the tile lies outside its box, or outside the old bounds
      beyond |= std::max(box.lo[axis], old.bounds.lo[axis]) < bounds.lo[axis] ||
                std::min(box.hi[axis], old.bounds.hi[axis]) > bounds.hi[axis];
    }
    if (!beyond) continue;
    BOOST_OUTCOME_TRY(stored, source_.read(i, {.cells = false}));
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
  manifest_.inputs.insert(manifest_.inputs.end(), options.inputs.begin(), options.inputs.end());
  manifest_.points_read += change.add.size();
  manifest_.filtered += plan_.removed_points;
  manifest_.vertices = manifest_.cells = 0;
  for (const TileEntry& entry : manifest_.tiles) {
    manifest_.vertices += entry.own_points;
    manifest_.cells += entry.main_cells;
  }
  manifest_.seconds.clear();
  manifest_.figures.clear();
  std::vector<DuplicatePair> duplicates = plan_.duplicates;
  bool duplicates_changed = plan_.duplicates_changed;
  for (const auto& [tile, end] : ends_) {
    duplicates.insert(duplicates.end(), end.duplicates.begin(), end.duplicates.end());
    duplicates_changed |= !end.duplicates.empty();
  }
  if (duplicates_changed) manifest_.other_heights.reset();  // results do not keep the heights of duplicates
  std::sort(duplicates.begin(), duplicates.end());
  return finish_store(folder_, manifest_, duplicates);
}

}  // namespace tessera
