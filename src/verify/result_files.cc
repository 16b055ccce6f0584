#include "src/verify/result_files.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <set>
#include <span>
#include <string>
#include <system_error>
#include <utility>

#include "src/files/checksum.h"
#include "src/files/descriptor.h"
#include "src/files/folder.h"
#include "src/files/there.h"
#include "src/store/manifest.h"
#include "src/store/vtk_xml.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

Error corrupt(const fs::path& path, const std::string& reason) {
  return error(Errc::corrupt, path.string() + ": " + reason);
}

// Programs open it instead of the tiles: it must lead to all of them, whole and in order. Made again rather than
// parsed, so that nothing in it can be overlooked.
Status check_master(const fs::path& out, const Manifest& manifest) {
  const auto path = master_file(out);
  BOOST_OUTCOME_TRYV(check_sum(path, manifest.master_xxh3));
  const std::string wanted = store::master_text(manifest);
  if (checksum(std::as_bytes(std::span(wanted))) == manifest.master_xxh3) return success();
  return corrupt(path, "is not the master file of the tiles in the manifest");
}

Status check_listed(const fs::path& out, const Manifest& manifest) {
  const auto folder = tiles_folder(out);
  std::set<fs::path> names;
  for (const auto& entry : manifest.tiles) {
    names.insert(tile_file(out, entry.tile).filename());
  }
  FolderReader reader(folder);
  while (const char* entry = reader.next()) {
    const fs::path name(entry);
    if (name.extension() == tile_file(out, TileId{0}).extension() && !names.contains(name))
      return corrupt(folder / name, "is no tile of the manifest");
  }
  // A result without tiles may be without the folder.
  if (reader.error() && !manifest.tiles.empty()) return io_error(folder, "cannot be listed", reader.error().value());
  return success();
}

}  // namespace

Status check_sum(const fs::path& path, std::uint64_t expected, SumOf what) {
  BOOST_OUTCOME_TRY(sum, checksum_file(path, what));
  if (sum == expected) return success();
  return corrupt(path, "its checksum is " + checksum_text(sum) + ", the manifest says " + checksum_text(expected) +
                           ": the file was changed or damaged");
}

Status check_files(const fs::path& out, const Manifest& manifest) {
  BOOST_OUTCOME_TRYV(check_master(out, manifest));
  const auto duplicates = duplicates_file(out);
  if (manifest.duplicates_xxh3 != 0) {
    BOOST_OUTCOME_TRYV(check_sum(duplicates, manifest.duplicates_xxh3, data_sum_of(manifest.format_version)));
  } else {
    BOOST_OUTCOME_TRY(there, is_there(duplicates));
    if (there) return corrupt(duplicates, "has no checksum in the manifest");
  }
  return check_listed(out, manifest);
}

Result<TileMesh> open_tile(const fs::path& out, const TileEntry& entry, const Manifest& manifest) {
  const auto path = tile_file(out, entry.tile);
  BOOST_OUTCOME_TRYV(check_sum(path, entry.xxh3, data_sum_of(manifest.format_version)));
  BOOST_OUTCOME_TRY(bytes, file_bytes(path));
  if (bytes != entry.bytes)
    return corrupt(path, "has " + std::to_string(bytes) + " bytes, the manifest says " + std::to_string(entry.bytes));
  // With the values of the attributes, though nothing is known of them: each vertex must have one.
  BOOST_OUTCOME_TRY(tile, read_tile(out, entry.tile, true));
  TileMesh& mesh = tile.mesh;
  const auto count = [](const auto& ghosts) {
    return static_cast<std::uint64_t>(std::count(ghosts.begin(), ghosts.end(), 0));
  };
  if (mesh.dimension != manifest.dimension) return corrupt(path, "has another dimension than the manifest");
  if (mesh.points.size() != entry.points || count(mesh.point_ghost) != entry.own_points ||
      mesh.cell_ghost.size() != entry.cells || count(mesh.cell_ghost) != entry.main_cells)
    return corrupt(path, "holds other numbers of vertices or cells than the manifest says");
  if (entry.cells > 0 && mesh.neighbors.empty() == manifest.neighbors)
    return corrupt(path, manifest.neighbors ? "has no neighbours, though the manifest says so"
                                            : "has neighbours, though the manifest says it has none");
  if (tile.schema != manifest.schema) return corrupt(path, "has other attributes than the manifest says");
  if (entry.tile.value < manifest.boxes.size()) {
    const Box& box = manifest.boxes[entry.tile.value];
    for (std::size_t i = 0; i < mesh.points.size(); ++i)
      if (mesh.point_ghost[i] == 0 && !box.contains(mesh.points[i]))
        return error(Errc::not_delaunay,
                     path.string() + ": own vertex " + to_string(mesh.ids[i]) + " lies outside the tile's box");
  }
  return std::move(mesh);
}

}  // namespace tessera
