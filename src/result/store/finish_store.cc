// The end of a result: writes the master file, the duplicates, and the manifest last.
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "src/base/files/checksum.h"
#include "src/base/files/folder.h"
#include "src/base/files/names.h"
#include "src/base/files/whole_file.h"
#include "src/result/store/duplicate_rows.h"
#include "src/result/store/duplicates.h"
#include "src/result/store/manifest.h"
#include "src/result/store/period.h"
#include "src/result/store/tile_layout.h"
#include "src/result/store/vtk_xml.h"

namespace tessera {

namespace fs = std::filesystem;

std::optional<Digest> sum_of_digests(const std::vector<TileEntry>& tiles) {
  Digest sum;
  for (const auto& entry : tiles) {
    if (!entry.digest) return std::nullopt;
    sum += *entry.digest;
  }
  return sum;
}

void remove_side_files(const fs::path& out) {
  const auto folder = tiles_folder(out);
  FolderReader reader(folder);
  while (const char* name = reader.next()) {
    const auto file = folder / name;
    if (is_done_name(file) || is_temporary_name(file)) ::unlink(file.c_str());
  }
}

Status finish_store(const fs::path& out, Manifest& manifest, DuplicateSort& duplicates,
                    const std::function<Status()>& before_manifest, DuplicateRowSort* rows) {
  static_assert(std::endian::native == std::endian::little);
  BOOST_OUTCOME_TRYV(make_directories(tiles_folder(out)));
  std::vector<fs::path> files;
  for (const TileEntry& entry : manifest.tiles) files.push_back(tile_file(out, entry));
  BOOST_OUTCOME_TRYV(sync_files(files));
  BOOST_OUTCOME_TRYV(sync_folder(tiles_folder(out)));
  std::sort(manifest.tiles.begin(), manifest.tiles.end(), [](const auto& a, const auto& b) { return a.tile < b.tile; });
  BOOST_OUTCOME_TRY(schema, store::stored_schema(manifest.schema));
  manifest.schema = schema;
  manifest.digest = sum_of_digests(manifest.tiles);

  const bool of_points = std::any_of(manifest.tiles.begin(), manifest.tiles.end(),
                                     [](const TileEntry& entry) { return entry.kind == TileKind::points; });
  if (!is_periodic(manifest))
    manifest.format_version = of_points || manifest.version > 1 ? changed_format : unchanged_format;

  const std::string master = store::master_text(manifest);
  manifest.master_xxh3 = checksum(std::as_bytes(std::span(master)));
  BOOST_OUTCOME_TRYV(write_whole(master_file(out), master));

  BOOST_OUTCOME_TRY(pairs, store::write_duplicates(out, duplicates));
  manifest.duplicates = pairs.count;
  manifest.duplicates_xxh3 = pairs.xxh3;
  BOOST_OUTCOME_TRY(rows_xxh3, store::write_duplicate_rows(out, rows, pairs.count));
  manifest.duplicate_rows_xxh3 = rows_xxh3;
  BOOST_OUTCOME_TRYV(before_manifest());
  BOOST_OUTCOME_TRYV(write_whole(manifest_file(out), store::manifest_to_text(manifest)));
  remove_side_files(out);
  return success();
}

Status finish_store(const fs::path& out, Manifest& manifest, std::span<const DuplicatePair> duplicates,
                    DuplicateRowSort* rows) {
  DuplicateSort sorted(out, duplicates.size() * sizeof(DuplicatePair));
  for (const DuplicatePair& pair : duplicates) {
    BOOST_OUTCOME_TRYV(sorted.push(pair));
  }
  return finish_store(
      out, manifest, sorted, [] { return success(); }, rows);
}

}  // namespace tessera
