#include "src/delaunay/update/changed_columns.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <iterator>
#include <string>

#include "src/base/files/folder.h"
#include "src/base/files/names.h"
#include "src/base/files/whole_file.h"
#include "src/base/on_threads.h"
#include "src/base/stopped.h"
#include "src/result/store/points_tile.h"
#include "src/result/store/tile_columns.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

std::size_t tail_of(const Manifest& manifest) {
  std::size_t bytes = 0;
  for (const ResultColumn& column : manifest.columns) bytes += column.of_cells ? 0 : size_of(column.type);
  return bytes;
}

Manifest draft_of(const Manifest& manifest, const std::map<TileId, TileEntry>& changed) {
  Manifest draft = without_columns(manifest);
  draft.tiles.clear();
  for (const auto& [tile, entry] : changed) draft.tiles.push_back(entry);
  return draft;
}

}  // namespace

ChangedColumns::ChangedColumns(const TileSource& old, fs::path scratch, Change change, fs::path to,
                               std::stop_token stop)
    : old_(old),
      draft_(TileSource::draft(std::move(scratch), draft_of(old.manifest(), change.changed)).stopped_by(stop)),
      change_(std::move(change)),
      to_(std::move(to)),
      stop_(std::move(stop)),
      tail_(tail_of(old.manifest())),
      with_total_(
          std::ranges::any_of(old.manifest().columns, [](const auto& column) { return column.total.has_value(); })),
      hull_(old, stop_) {}

std::vector<std::byte> ChangedColumns::row_of(const PassValues& values, std::size_t vertex) const {
  std::vector<std::byte> row;
  row.reserve(tail_);
  for (std::size_t c = 0; c < values.size(); ++c) {
    const ResultColumn& column = old_.manifest().columns[c];
    if (column.of_cells) continue;
    const std::size_t size = size_of(column.type);
    row.insert(row.end(), &values[c][vertex * size], &values[c][vertex * size] + size);
  }
  return row;
}

Status ChangedColumns::compute_tile(ColumnsAgain& again, std::size_t index) {
  BOOST_OUTCOME_TRY(tile, draft_.read(index, {}));
  BOOST_OUTCOME_TRY(values, again.values(index, tile));
  const TileMesh& mesh = tile.mesh;
  if (with_total_) {
    BOOST_OUTCOME_TRYV(hull_.look_at(draft_.entry(index).tile, mesh));
  }
  const std::lock_guard lock(mutex_);
  for (std::size_t v = 0; v < mesh.ids.size(); ++v) {
    if (mesh.point_ghost[v] != 0) {
      if (!draft_.find(mesh.owners[v])) neighbours_.insert(mesh.owners[v]);
      continue;
    }
    rows_[mesh.ids[v]] = row_of(values, v);
  }
  made_[index] = {mesh.ids, mesh.owners, std::move(values)};
  return success();
}

Status ChangedColumns::compute(unsigned threads) {
  const ColumnsAgain::Wanted wanted{old_.folder(), old_.manifest().columns, change_.duplicates};
  BOOST_OUTCOME_TRY(again, ColumnsAgain::of(draft_, wanted, stop_));
  if (with_total_) {
    for (const TileId tile : change_.gone) {
      BOOST_OUTCOME_TRYV(hull_.look_at_gone(tile));
    }
  }
  made_.resize(draft_.tiles());
  std::atomic<bool> failed{false};
  std::atomic<std::size_t> next{0};
  return on_threads(threads, failed, [&]() -> Status {
    for (std::size_t i = next++; i < made_.size() && !failed; i = next++) {
      throw_if_stopped(stop_);
      BOOST_OUTCOME_TRYV(compute_tile(again, i));
    }
    return success();
  });
}

// The vertices of unchanged tiles that have another number of duplicates now.
Result<PointIds> ChangedColumns::other_duplicates() const {
  const auto kept_of = [](const std::vector<DuplicatePair>& pairs) {
    std::vector<PointId> kept;
    for (const DuplicatePair& pair : pairs) kept.push_back(pair.kept);
    std::sort(kept.begin(), kept.end());
    return kept;
  };
  std::vector<DuplicatePair> old;
  if (old_.manifest().duplicates_xxh3 != 0) {
    BOOST_OUTCOME_TRY(pairs, read_duplicates(old_.folder(), old_.manifest()));
    old = std::move(pairs);
  }
  const auto before = kept_of(old), now = kept_of(change_.duplicates);
  std::vector<PointId> other;  // each as often as the numbers differ
  std::set_symmetric_difference(before.begin(), before.end(), now.begin(), now.end(), std::back_inserter(other));
  PointIds vertices(other);
  for (const PointId id : other) {
    if (rows_.contains(id)) vertices.erase(id);
  }
  for (std::size_t i = 0; i < old_.tiles() && vertices.size() > 0; ++i) {
    const TileId tile = old_.entry(i).tile;
    if (!draft_.find(tile) && !change_.gone.contains(tile)) continue;
    BOOST_OUTCOME_TRY(ids, old_.read_own_ids(i));
    for (const PointId id : ids) vertices.erase(id);
  }
  return vertices;
}

// Densities depend on duplicates, which may come and go where no cell changes.
Status ChangedColumns::recompute(unsigned threads) {
  if (std::ranges::none_of(old_.manifest().columns, depends_on_duplicates)) return success();
  BOOST_OUTCOME_TRY(vertices, other_duplicates());
  const TileSource plain = old_.without_columns().stopped_by(stop_);
  const ColumnsAgain::Wanted wanted{old_.folder(), old_.manifest().columns, change_.duplicates};
  BOOST_OUTCOME_TRY(again, ColumnsAgain::of(plain, wanted, stop_));
  std::atomic<std::size_t> found{0}, next{0};
  std::atomic<bool> failed{false};
  return on_threads(threads, failed, [&]() -> Status {
    for (std::size_t i = next++; i < old_.tiles() && found < vertices.size() && !failed; i = next++) {
      const TileId tile = old_.entry(i).tile;
      if (draft_.find(tile) || change_.gone.contains(tile)) continue;
      throw_if_stopped(stop_);
      BOOST_OUTCOME_TRY(ids, old_.read_own_ids(i));
      const auto here =
          static_cast<std::size_t>(std::ranges::count_if(ids, [&](PointId id) { return vertices.contains(id); }));
      found += here;
      if (here == 0) continue;
      BOOST_OUTCOME_TRYV(recompute_tile(again, i));
    }
    return success();
  });
}

Status ChangedColumns::recompute_tile(ColumnsAgain& again, std::size_t index) {
  const TileId self = old_.entry(index).tile;
  BOOST_OUTCOME_TRY(stored, old_.stopped_by(stop_).read(index, {.cells = true, .rows = true}));
  BOOST_OUTCOME_TRY(values, again.values(index, stored));
  const TileMesh& mesh = stored.mesh;
  const std::size_t width = row_bytes(stored.schema);
  std::vector<std::uint8_t> differs(mesh.ids.size(), 0);
  const std::lock_guard lock(mutex_);
  recomputed_.insert(self);
  for (std::size_t v = 0; v < mesh.ids.size(); ++v) {
    if (mesh.point_ghost[v] != 0) continue;
    auto row = row_of(values, v);
    differs[v] = std::memcmp(&stored.rows[(v + 1) * width - tail_], row.data(), tail_) != 0 ? 1 : 0;
    rows_[mesh.ids[v]] = std::move(row);
  }
  // A tile that has a vertex of this one as a foreign vertex owns another vertex of one of its cells.
  const std::size_t corners = static_cast<std::size_t>(mesh.dimension) + 1;
  for (std::size_t at = 0; at < mesh.cells.size(); at += corners) {
    const auto cell = std::span(mesh.cells).subspan(at, corners);
    if (std::ranges::none_of(cell, [&](std::int32_t v) { return differs[static_cast<std::size_t>(v)] != 0; })) continue;
    for (const std::int32_t v : cell) {
      const TileId owner = mesh.owners[static_cast<std::size_t>(v)];
      if (!draft_.find(owner)) neighbours_.insert(owner);
    }
  }
  return success();
}

bool ChangedColumns::patch(StoredTile& stored) const {
  const std::size_t width = row_bytes(stored.schema);
  bool differs = false;
  for (std::size_t v = 0; v < stored.mesh.ids.size(); ++v) {
    const TileId owner = stored.mesh.owners[v];
    if (!draft_.find(owner) && !recomputed_.contains(owner)) continue;
    const auto found = rows_.find(stored.mesh.ids[v]);
    if (found == rows_.end()) continue;
    std::byte* const tail = &stored.rows[(v + 1) * width - tail_];
    if (std::memcmp(tail, found->second.data(), tail_) == 0) continue;
    std::memcpy(tail, found->second.data(), tail_);
    differs = true;
  }
  return differs;
}

// Keeps the values of the tile's own vertices for the changed tiles.
Status ChangedColumns::look_at_neighbour(TileId tile) {
  throw_if_stopped(stop_);
  const auto index = old_.find(tile);
  if (!index) return error(Errc::internal, "a tile that did not exist has not changed");
  BOOST_OUTCOME_TRY(stored, old_.stopped_by(stop_).read(*index, {.cells = true, .rows = true, .cell_columns = true}));
  const std::size_t width = row_bytes(stored.schema);
  for (std::size_t v = 0; v < stored.mesh.ids.size() && !recomputed_.contains(tile); ++v) {
    if (stored.mesh.owners[v] != tile) continue;
    const std::byte* const tail = &stored.rows[(v + 1) * width - tail_];
    rows_[stored.mesh.ids[v]] = std::vector<std::byte>(tail, tail + tail_);
  }
  if (!patch(stored)) return success();
  return write_patched(*index, stored);
}

Status ChangedColumns::write_patched(std::size_t index, const StoredTile& stored) {
  const Manifest& plain = draft_.manifest();
  const std::size_t width = row_bytes(stored.schema), kept = width - tail_;
  const std::size_t n = stored.mesh.ids.size();
  std::vector<std::byte> rows(n * kept);
  for (std::size_t v = 0; v < n && kept > 0; ++v) std::memcpy(&rows[v * kept], &stored.rows[v * width], kept);
  TileEntry entry = old_.entry(index);
  const StoreOptions options{.neighbors = plain.neighbors, .schema = plain.schema, .stop = stop_};
  if (entry.kind == TileKind::points) {
    BOOST_OUTCOME_TRY(points, old_.without_columns().read_as_points(index, {.rows = true, .cell_columns = false}));
    BOOST_OUTCOME_TRYV(
        write_points_tile(draft_.folder(), view_of(points), {entry.cells, entry.main_cells, {}}, options));
  } else {
    BOOST_OUTCOME_TRYV(write_tile(draft_.folder(), entry.tile, stored.mesh, rows, options));
  }
  PassValues values;
  std::size_t cells = 0, offset = kept;
  for (const ResultColumn& column : old_.manifest().columns) {
    if (column.of_cells) {
      values.push_back(stored.cell_columns[cells++]);
      continue;
    }
    const std::size_t size = size_of(column.type);
    auto& all = values.emplace_back(n * size);
    for (std::size_t v = 0; v < n; ++v) std::memcpy(&all[v * size], &stored.rows[v * width + offset], size);
    offset += size;
  }
  return finish(entry, values);
}

Status ChangedColumns::write_changed(std::size_t index) {
  throw_if_stopped(stop_);
  Made& made = made_[index];
  const TileEntry& entry = draft_.entry(index);
  const auto& columns = old_.manifest().columns;
  for (std::size_t v = 0; v < made.ids.size() && tail_ > 0; ++v) {
    if (made.owners[v] == entry.tile) continue;
    const auto found = rows_.find(made.ids[v]);
    if (found == rows_.end())
      return error(Errc::internal, "the columns of point " + to_string(made.ids[v]) + " are not known");
    const std::byte* from = found->second.data();
    for (std::size_t c = 0; c < columns.size(); ++c) {
      if (columns[c].of_cells) continue;
      const std::size_t size = size_of(columns[c].type);
      std::memcpy(&made.values[c][v * size], from, size);
      from += size;
    }
  }
  return finish(entry, made.values);
}

// Adds the columns to the file without columns, which is in the scratch folder.
Status ChangedColumns::finish(TileEntry entry, const PassValues& values) {
  std::vector<store::ColumnValues> columns;
  for (std::size_t c = 0; c < values.size(); ++c) {
    const ResultColumn& column = old_.manifest().columns[c];
    columns.push_back({column.of_cells, {column.name, column.type}, values[c]});
  }
  const fs::path final_name = tile_file(old_.folder(), entry);
  TileEntry plain = entry;
  plain.version = 1;
  const fs::path from = tile_file(draft_.folder(), plain), to = tile_file(to_, plain);
  const store::TileCopy copy{.tile = entry.tile, .from = from, .to = to, .final_name = final_name};
  BOOST_OUTCOME_TRY(written, entry.kind == TileKind::points ? store::copy_points_with_columns(copy, columns, stop_)
                                                            : store::copy_with_columns(copy, columns, stop_));
  entry.bytes = written.bytes;
  entry.xxh3 = written.xxh3;
  finished_.push_back({entry, to});
  return draft_.find(entry.tile) ? Status(success()) : remove_file(from);
}

Result<FinishedTiles> ChangedColumns::make(unsigned threads) {
  BOOST_OUTCOME_TRYV(make_directories(tiles_folder(to_)));
  BOOST_OUTCOME_TRYV(compute(threads));
  BOOST_OUTCOME_TRYV(recompute(threads));
  for (const TileId tile : neighbours_) {
    BOOST_OUTCOME_TRYV(look_at_neighbour(tile));
  }
  for (std::size_t i = 0; i < made_.size(); ++i) {
    BOOST_OUTCOME_TRYV(write_changed(i));
  }
  return FinishedTiles{std::move(finished_), hull_.is_possible()};
}

}  // namespace tessera
