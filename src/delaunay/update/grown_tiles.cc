#include "src/delaunay/update/grown_tiles.h"

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>

#include <tsl/robin_map.h>

#include "src/base/files/folder.h"
#include "src/base/files/linked_file.h"
#include "src/base/files/names.h"
#include "src/base/files/whole_file.h"
#include "src/base/json/json_text.h"
#include "src/base/mix_hash.h"
#include "src/base/stopped.h"
#include "src/delaunay/update/parts_of_tile.h"
#include "src/delaunay/update/points_of_mesh.h"
#include "src/tiling/refine.h"
#include "src/tiling/routed_cloud.h"
#include "src/tiling/tile/rebuild.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

TileSource draft_of_changed(const TileSource& source, const ChangedTiles& changed) {
  Manifest manifest = source.manifest();
  manifest.tiles.clear();
  for (const auto& [tile, end] : changed.ends) {
    if (end.entry) manifest.tiles.push_back(*end.entry);
  }
  return TileSource::draft(changed.folder, std::move(manifest));
}

// The vertices of a tile are few enough to be told apart by their ids.
std::vector<std::byte> rows_for(const std::vector<PointId>& ids, const StoredTile& whole) {
  const std::size_t width = row_bytes(whole.schema);
  std::vector<std::byte> rows(ids.size() * width);
  if (width == 0) return rows;
  tsl::robin_map<PointId, std::size_t, MixHash> places;
  for (std::size_t v = 0; v < whole.mesh.ids.size(); ++v) places[whole.mesh.ids[v]] = v;
  for (std::size_t v = 0; v < ids.size(); ++v)
    std::memcpy(&rows[v * width], &whole.rows[places.at(ids[v]) * width], width);
  return rows;
}

Bounds own_bounds(const TileMesh& mesh) {
  Bounds bounds;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    if (mesh.point_ghost[v] == 0) bounds.add(mesh.points[v]);
  }
  return bounds;
}

}  // namespace

std::uint64_t limit_of_tiles(const Manifest& manifest, std::uint64_t asked, std::uint64_t least) {
  if (asked != 0) return asked;
  const auto partition = parse_json(manifest.partition);
  const auto known = partition.find("split_above");
  if (known != partition.end() && known->is_number_unsigned() && *known != 0) return known->get<std::uint64_t>();
  std::uint64_t largest = 0;
  for (const TileEntry& entry : manifest.tiles) largest = std::max(largest, entry.own_points);
  return std::max(2 * largest, least);
}

std::string remember_limit(const std::string& partition, std::uint64_t limit) {
  auto value = parse_json(partition);
  value["split_above"] = limit;
  return json_text(value);
}

GrownTiles::GrownTiles(const TileSource& source, const ChangedTiles& changed, std::stop_token stop)
    : source_(source),
      changed_(changed),
      draft_(draft_of_changed(source, changed).stopped_by(stop)),
      stop_(std::move(stop)) {}

Result<std::set<TileId>> GrownTiles::split(Partition& partition, std::uint64_t limit) {
  std::set<TileId> split;
  for (std::size_t i = 0; i < draft_.tiles(); ++i) {
    if (draft_.entry(i).own_points <= limit || partition.kind() == PartitionKind::random) continue;
    throw_if_stopped(stop_);
    BOOST_OUTCOME_TRY(stored, draft_.read(i, {.cells = false}));
    std::vector<Point> own;
    own.reserve(draft_.entry(i).own_points);
    for (std::size_t v = 0; v < stored.mesh.points.size(); ++v) {
      if (stored.mesh.point_ghost[v] == 0) own.push_back(stored.mesh.points[v]);
    }
    const TileId tile = draft_.entry(i).tile;
    if (split_by_sample(partition, tile, std::move(own), 1, limit)) split.insert(tile);
  }
  return split;
}

// Tiles with no new file are as the result has them.
Result<StoredTile> GrownTiles::read(TileId tile, bool cells) const {
  throw_if_stopped(stop_);
  const TileFields fields{.cells = cells, .rows = true};
  if (const auto index = draft_.find(tile)) return draft_.read(*index, fields);
  const auto index = source_.find(tile);
  if (!index) return error(Errc::internal, "tile " + to_string(tile) + " is beside a split tile, and has no file");
  return source_.stopped_by(stop_).read(*index, fields);
}

TileKind GrownTiles::kind_of(TileId tile) const {
  if (const auto index = draft_.find(tile)) return draft_.entry(*index).kind;
  const auto index = source_.find(tile);
  return index ? source_.entry(*index).kind : TileKind::cells;
}

void GrownTiles::find_owners(TileMesh& mesh) const {
  for (std::size_t v = 0; v < mesh.owners.size(); ++v) {
    if (split_->contains(mesh.owners[v])) mesh.owners[v] = partition_->tile_of(mesh.points[v]);
  }
}

Result<TileEntry> GrownTiles::write_file(TileId tile, TileKind kind, const TileMesh& mesh,
                                         std::span<const std::byte> rows) const {
  const Manifest& manifest = source_.manifest();
  const StoreOptions options{.neighbors = manifest.neighbors, .schema = manifest.schema, .stop = stop_};
  if (kind == TileKind::points) return write_as_points(made_.folder, tile, mesh, rows, options);
  return write_tile(made_.folder, tile, mesh, rows, options);
}

Status GrownTiles::write_part(TileId tile, TileKind kind, const StoredTile& whole, const PartOfTile& part) {
  throw_if_stopped(stop_);
  const TileMesh& mesh = whole.mesh;
  std::vector<LocalPoint> own;
  own.reserve(part.own.size());
  for (const std::int32_t v : part.own) own.push_back({mesh.points[v], mesh.ids[v]});
  LoadedTile ordered = order_points(own, mesh.dimension);
  std::vector<SharedPoint> foreign;
  for (const std::int32_t v : part.foreign) foreign.push_back({mesh.points[v], mesh.ids[v], mesh.owners[v], 0});
  put_in_hilbert_order(foreign, mesh.dimension);
  RebuildInput input{.dimension = mesh.dimension,
                     .self = tile,
                     .own = ordered.points.size(),
                     .points = std::move(ordered.points),
                     .ids = std::move(ordered.ids),
                     .owners = std::vector<TileId>(part.own.size(), tile),
                     .stop = stop_};
  for (const SharedPoint& p : foreign) {
    input.points.push_back(p.at);
    input.ids.push_back(p.id);
    input.owners.push_back(p.tile);
  }
  auto rebuilt = rebuild(std::move(input));
  if (!rebuilt) return error(rebuilt.error().code, "a part of a split tile: " + rebuilt.error().where);
  const TileMesh& cut = rebuilt.value();
  BOOST_OUTCOME_TRY(entry, write_file(tile, kind, cut, rows_for(cut.ids, whole)));
  TileEnd& end = made_.ends[tile];  // a new one for a new tile
  end.changed = true;
  end.entry = entry;
  written_.insert(tile);
  return success();
}

// What else the change has noted of the tile stays with the part that has its number: sums are over all tiles.
Status GrownTiles::write_parts(TileId tile) {
  BOOST_OUTCOME_TRY(whole, read(tile, true));
  for (std::size_t v = 0; v < whole.mesh.owners.size(); ++v) {
    const TileId owner = whole.mesh.owners[v];
    if (owner != tile && !split_->contains(owner)) beside_.insert(owner);
  }
  find_owners(whole.mesh);
  const TileKind kind = kind_of(tile);
  for (const auto& [number, part] : parts_of(whole.mesh)) {
    BOOST_OUTCOME_TRYV(write_part(number, kind, whole, part));
  }
  return success();
}

Status GrownTiles::write_beside(TileId tile) {
  BOOST_OUTCOME_TRY(stored, read(tile, true));
  TileMesh& mesh = stored.mesh;
  find_owners(mesh);
  const auto corners = static_cast<std::size_t>(mesh.dimension) + 1;
  for (std::size_t c = 0; c < mesh.cell_ghost.size(); ++c) {
    TileId main = tile;
    for (std::size_t i = 0; i < corners; ++i) main = std::min(main, mesh.owners[mesh.cells[c * corners + i]]);
    mesh.cell_ghost[c] = main == tile ? 0 : 1;
  }
  BOOST_OUTCOME_TRY(entry, write_file(tile, kind_of(tile), mesh, stored.rows));
  TileEnd& end = made_.ends[tile];
  end.changed = true;
  end.entry = entry;
  end.bounds = own_bounds(mesh);
  written_.insert(tile);
  return success();
}

Result<ChangedTiles> GrownTiles::write(const Partition& partition, const std::set<TileId>& split,
                                       const fs::path& folder) {
  BOOST_OUTCOME_TRYV(remove_whole(folder));
  BOOST_OUTCOME_TRYV(make_directories(tiles_folder(folder)));
  partition_ = &partition;
  split_ = &split;
  made_ = {changed_.ends, folder};
  written_.clear();
  beside_.clear();
  for (const TileId tile : split) {
    BOOST_OUTCOME_TRYV(write_parts(tile));
  }
  for (const TileId tile : beside_) {
    BOOST_OUTCOME_TRYV(write_beside(tile));
  }
  for (std::size_t i = 0; i < draft_.tiles(); ++i) {
    if (written_.contains(draft_.entry(i).tile)) continue;
    BOOST_OUTCOME_TRYV(link_or_copy(draft_.file(i), tile_file(folder, draft_.entry(i))));
  }
  return std::move(made_);
}

}  // namespace tessera
