#include "src/result/verify/result_files.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <set>
#include <span>
#include <string>
#include <system_error>
#include <utility>

#include "src/base/attribute.h"
#include "src/base/files/checksum.h"
#include "src/base/files/descriptor.h"
#include "src/base/files/folder.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/result/check_sum.h"
#include "src/result/far_copy.h"
#include "src/result/old_versions.h"
#include "src/result/store/duplicate_rows.h"
#include "src/result/store/manifest.h"
#include "src/result/store/period.h"
#include "src/result/store/vtk_xml.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

Error corrupt(const fs::path& path, const std::string& reason) {
  return error(Errc::corrupt, path.string() + ": " + reason);
}

std::uint64_t sum_of_text(const std::string& text) { return checksum(std::as_bytes(std::span(text))); }

// The master file of the version before remains when a writer was ended between manifest and master file. It refers to
// tiles that still exist.
Status check_previous_master(const TileSource& source, const fs::path& path) {
  BOOST_OUTCOME_TRY(olds, result::old_versions(source.folder()));
  for (const auto& old : olds) {
    if (old.version + 1 != source.manifest().version) continue;
    BOOST_OUTCOME_TRY(bytes, read_whole(old.file));
    BOOST_OUTCOME_TRY(manifest, parse_manifest(old.file, bytes));
    if (sum_of_text(store::master_text(manifest)) != *source.manifest().previous_master_xxh3) continue;
    for (const auto& entry : manifest.tiles) {
      BOOST_OUTCOME_TRY(there, is_there(tile_file(source.folder(), entry)));
      if (!there) return corrupt(path, "names tiles of the version before, which are missing");
    }
    return success();
  }
  return corrupt(path, "is the master file of the version before, whose manifest is missing");
}

// Programs open the master file instead of the tiles, so it must refer to all of them, complete and in order. It is
// made again rather than parsed, so that nothing in it can be overlooked.
Status check_master(const TileSource& source) {
  const Manifest& manifest = source.manifest();
  const auto path = master_file(source.folder());
  if (manifest.previous_master_xxh3) {
    BOOST_OUTCOME_TRY(sum, checksum_file(path));
    if (sum == *manifest.previous_master_xxh3 && sum != manifest.master_xxh3)
      return check_previous_master(source, path);
  }
  BOOST_OUTCOME_TRYV(check_sum(path, manifest.master_xxh3));
  if (sum_of_text(store::master_text(manifest)) == manifest.master_xxh3) return success();
  return corrupt(path, "is not the master file of the tiles in the manifest");
}

// Beside the tiles of this version there may be tiles of older and newer versions, and of a version that was never
// completed.
Status check_listed(const TileSource& source, const Manifest& current) {
  const Manifest& manifest = source.manifest();
  const std::uint32_t newest = std::max(current.version, manifest.version);
  const auto folder = tiles_folder(source.folder());
  std::set<fs::path> names = result::tile_names(manifest);
  names.merge(result::tile_names(current));
  BOOST_OUTCOME_TRY(olds, result::old_versions(source.folder()));
  for (const auto& old : olds) {
    BOOST_OUTCOME_TRY(bytes, read_whole(old.file));
    BOOST_OUTCOME_TRY(other, parse_manifest(old.file, bytes));
    names.merge(result::tile_names(other));
  }
  FolderReader reader(folder);
  while (const char* entry = reader.next()) {
    const fs::path name(entry);
    const bool unfinished = version_of_tile_file(name).value_or(0) > newest;
    if (kind_of_tile_file(name) && !names.contains(name) && !unfinished)
      return corrupt(folder / name, "is not a tile of the manifest");
  }
  // A result without tiles may lack the folder.
  if (reader.error() && !manifest.tiles.empty()) return io_error(folder, "cannot be listed", reader.error().value());
  return success();
}

Status check_duplicate_rows(const fs::path& out, const Manifest& manifest) {
  const auto file = duplicate_rows_of(out, manifest);
  if (manifest.duplicate_rows_xxh3 == 0) {
    if (has_lists_of_versions(manifest.format_version)) return success();  // the file may be of another version
    BOOST_OUTCOME_TRY(there, is_there(file));
    return there ? corrupt(file, "has no checksum in the manifest") : Status(success());
  }
  BOOST_OUTCOME_TRYV(check_sum(file, manifest.duplicate_rows_xxh3, data_sum_of(manifest.format_version)));
  BOOST_OUTCOME_TRY(bytes, file_bytes(file));
  const std::uint64_t expected = manifest.duplicates * row_bytes(carried_schema(manifest));
  if (bytes == expected) return success();
  return corrupt(file, "has " + std::to_string(bytes) + " bytes, but the attributes of " +
                           std::to_string(manifest.duplicates) + " duplicates take " + std::to_string(expected));
}

// Of a far result only what the manifest names is looked at: what else a store has there is not listed.
Status check_far_files(const TileSource& source) {
  const fs::path& out = source.folder();
  const Manifest& manifest = source.manifest();
  if (sum_of_text(store::master_text(manifest)) != manifest.master_xxh3)
    return corrupt(master_file(out), "is not the master file of the tiles in the manifest");
  for (const auto& [name, told] : result::files_beside_tiles(manifest)) {
    BOOST_OUTCOME_TRYV(source.check(out / name, told));
  }
  return success();
}

}  // namespace

Status check_files(const TileSource& source) {
  if (source.is_far()) return check_far_files(source);
  const fs::path& out = source.folder();
  const Manifest& manifest = source.manifest();
  BOOST_OUTCOME_TRY(current, read_manifest(out));
  if (current.version == manifest.version) {  // the master file is that of the newest version
    BOOST_OUTCOME_TRYV(check_master(source));
  }
  if (manifest.duplicates_xxh3 != 0) {
    BOOST_OUTCOME_TRYV(
        check_sum(duplicates_of(out, manifest), manifest.duplicates_xxh3, data_sum_of(manifest.format_version)));
  } else if (!has_lists_of_versions(manifest.format_version)) {  // later, the file may be of another version
    const auto duplicates = duplicates_file(out);
    BOOST_OUTCOME_TRY(there, is_there(duplicates));
    if (there) return corrupt(duplicates, "has no checksum in the manifest");
  }
  BOOST_OUTCOME_TRYV(check_duplicate_rows(out, manifest));
  return check_listed(source, current);
}

Result<TileMesh> open_tile(const TileSource& source, std::size_t index) {
  const Manifest& manifest = source.manifest();
  const TileEntry& entry = source.entry(index);
  const auto path = source.file(index);
  BOOST_OUTCOME_TRYV(source.check(index));
  // Attributes and columns are read only to check that each vertex and each cell has a value.
  BOOST_OUTCOME_TRY(tile, source.read(index, {.rows = true, .cell_columns = true}));
  TileMesh& mesh = tile.mesh;
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
