#include "src/surface/folder_store.h"

#include <charconv>
#include <string>

#include "src/base/files/folder.h"
#include "src/base/files/frame.h"
#include "src/base/files/names.h"
#include "src/base/files/surface_names.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/result/store/tile_store.h"

namespace tessera::surface {

namespace fs = std::filesystem;

namespace {

fs::path folder_of(const fs::path& run, StepOutput what) {
  return surface_kept_folder(run, static_cast<std::uint32_t>(what));
}
fs::path file_of(const fs::path& run, StepOutput what, TileId tile) {
  return surface_kept_file(folder_of(run, what), tile.value);
}
// Files of one tile, but of different kinds, must not be mistaken for each other.
FrameOwner owner_of(std::uint64_t seal, StepOutput what, TileId tile) {
  return {seal, std::uint64_t{tile.value} * outputs_count + static_cast<std::uint64_t>(what)};
}

}  // namespace

FolderStore::FolderStore(const ResultInput& input)
    : run_(input.run),
      seal_(input.seal),
      node_(input.node),
      stop_(input.stop),
      tiles_(input.source, surface_tiles_folder(input.own), input.memory_bytes) {}

Result<std::unique_ptr<FolderStore>> FolderStore::open(const ResultInput& input) {
  for (std::uint32_t what = 0; what < outputs_count; ++what) {
    BOOST_OUTCOME_TRYV(make_directories(folder_of(input.run, static_cast<StepOutput>(what))));
  }
  // This process does not know what an earlier process has left there.
  BOOST_OUTCOME_TRYV(remove_whole(surface_tiles_folder(input.own)));
  BOOST_OUTCOME_TRYV(make_directories(surface_tiles_folder(input.own)));
  return std::unique_ptr<FolderStore>(new FolderStore(input));
}

Result<std::size_t> FolderStore::place_of(TileId tile) const {
  const auto place = tiles_.source().find(tile);
  if (!place)
    return error(Errc::corrupt, tiles_.source().folder().string() + ": a vertex is of tile " + to_string(tile) +
                                    ", which the manifest does not have");
  return *place;
}

Result<std::unique_ptr<SurfaceTile>> FolderStore::take(TileId tile) {
  BOOST_OUTCOME_TRY(place, place_of(tile));
  return tiles_.take(place);
}

Status FolderStore::give_back(std::unique_ptr<SurfaceTile> tile) {
  BOOST_OUTCOME_TRY(place, place_of(tile->self()));
  return tiles_.give_back(place, std::move(tile));
}

Status FolderStore::write(StepOutput what, TileId tile, std::span<const std::byte> bytes) {
  return write_frame(file_of(run_, what, tile), ScratchKind::kept, owner_of(seal_, what, tile), bytes);
}

Result<Bytes> FolderStore::read(StepOutput what, TileId tile) { return read_kept(run_, seal_, what, tile); }

Result<Bytes> FolderStore::keep_triangles(TileId tile, const StoredTile& triangles) {
  if (triangles.mesh.cells.empty()) return Bytes();
  BOOST_OUTCOME_TRY(entry, write_tile(surface_triangles(run_), tile, triangles.mesh, triangles.rows,
                                      {.neighbors = false, .schema = triangles.schema, .node = node_, .stop = stop_}));
  return bytes_of(entry);
}

Result<Bytes> read_kept(const fs::path& run, std::uint64_t seal, StepOutput what, TileId tile) {
  return read_frame(file_of(run, what, tile), ScratchKind::kept, owner_of(seal, what, tile));
}

Result<std::vector<TileId>> tiles_kept(const fs::path& run, StepOutput what) {
  std::vector<TileId> tiles;
  const fs::path folder = folder_of(run, what);
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
  return tiles;
}

}  // namespace tessera::surface
