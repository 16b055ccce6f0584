#include "src/delaunay/update/update_folder.h"

#include <algorithm>
#include <charconv>
#include <string>
#include <utility>

#include "src/base/files/folder.h"
#include "src/base/files/frame.h"
#include "src/base/files/there.h"
#include "src/base/files/update_names.h"
#include "src/base/stopped.h"
#include "src/delaunay/update/points_of_mesh.h"
#include "src/exchange/tile_storage.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

// Files of one tile, but of different kinds, must not be mistaken for each other.
FrameOwner owner_of(std::uint64_t seal, TileId tile, bool end) {
  return {seal, std::uint64_t{tile.value} * 2 + (end ? 1 : 0)};
}

}  // namespace

UpdateFolder::UpdateFolder(const ResultInput& input, std::shared_ptr<const UpdatePlan> plan, bool writes)
    : source_(input.source),
      run_(input.run),
      seal_(input.seal),
      node_(input.node),
      stop_(input.stop),
      rows_(input.source, std::move(plan), input.memory_bytes),
      writes_(writes),
      many_nodes_(input.own != input.run) {}

Result<TileMesh> UpdateFolder::read(TileId tile, bool cells) {
  const auto index = source_.find(tile);
  if (!index) {
    TileMesh none;
    none.dimension = source_.manifest().dimension;
    return none;
  }
  BOOST_OUTCOME_TRY(stored, source_.read(*index, {.cells = cells}));
  return std::move(stored.mesh);
}

Status UpdateFolder::keep_told(TileId tile, const ToldOfHoles& told) {
  return write_frame(update_tile_file(update_told_folder(run_), tile), ScratchKind::kept, owner_of(seal_, tile, false),
                     bytes_of(told));
}

Result<ToldOfHoles> UpdateFolder::told(TileId tile) {
  const fs::path file = update_tile_file(update_told_folder(run_), tile);
  BOOST_OUTCOME_TRY(there, is_there(file));
  if (!there) return ToldOfHoles{};
  BOOST_OUTCOME_TRY(bytes, read_frame(file, ScratchKind::kept, owner_of(seal_, tile, false)));
  auto told = told_of(bytes);
  if (!told) return damaged(tile, "list of points around holes");
  return std::move(*told);
}

Status UpdateFolder::store(TileId tile, TileEnd end, CollectedTile* cells) {
  throw_if_stopped(stop_);
  if (cells != nullptr && writes_) {
    BOOST_OUTCOME_TRY(entry, write(tile, *cells));
    end.entry = entry;
  }
  return write_frame(update_tile_file(update_ends_folder(run_), tile), ScratchKind::kept, owner_of(seal_, tile, true),
                     bytes_of(end));
}

Result<TileEntry> UpdateFolder::write(TileId tile, CollectedTile& cells) {
  const Manifest& manifest = source_.manifest();
  BOOST_OUTCOME_TRY(rows, rows_.of(tile, cells.mesh.ids, cells.mesh.owners));
  const StoreOptions options{
      .neighbors = manifest.neighbors, .schema = manifest.schema, .node = node_, .sync = many_nodes_, .stop = stop_};
  const fs::path folder = update_result_folder(run_);
  if (kind_in(source_, tile) == TileKind::points)
    return write_as_points(folder, tile, std::move(cells).whole(), rows, options);
  return write_tile(folder, tile, cells.mesh, cells, rows, options);
}

Result<TileEnd> read_end(const fs::path& run, std::uint64_t seal, TileId tile) {
  BOOST_OUTCOME_TRY(bytes, read_frame(update_tile_file(update_ends_folder(run), tile), ScratchKind::kept,
                                      owner_of(seal, tile, true)));
  auto end = tile_end_of(bytes);
  if (!end) return damaged(tile, "record of what it has become");
  return std::move(*end);
}

Result<std::vector<TileId>> tiles_in(const fs::path& folder) {
  std::vector<TileId> tiles;
  BOOST_OUTCOME_TRY(there, is_there(folder));
  if (!there) return tiles;
  BOOST_OUTCOME_TRY(files, sorted_names(folder));
  for (const fs::path file : files) {
    const std::string name = file.stem().string();
    std::uint32_t tile = 0;
    const auto [end, failed] = std::from_chars(name.data(), name.data() + name.size(), tile);
    if (failed == std::errc() && end == name.data() + name.size() && file.extension() == ".bin")
      tiles.push_back(TileId{tile});
  }
  std::sort(tiles.begin(), tiles.end());
  return tiles;
}

}  // namespace tessera
