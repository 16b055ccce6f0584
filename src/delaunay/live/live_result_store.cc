// How the newest version of a live result is written.
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <numeric>
#include <string>

#include "src/base/files/folder.h"
#include "src/base/files/temporary.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/base/on_threads.h"
#include "src/delaunay/live/live_result.h"
#include "src/delaunay/live/live_writer.h"

namespace tessera {

namespace fs = std::filesystem;

Result<Manifest> LiveResult::write_to(const fs::path& to) const {
  const std::lock_guard lock(writer_);
  BOOST_OUTCOME_TRY(there, is_there(to));
  if (there) return error(Errc::usage, to.string() + ": exists already");
  BOOST_OUTCOME_TRY(folder, TemporaryFolder::make(temporary_name_of_process(to)));
  BOOST_OUTCOME_TRYV(make_directories(tiles_folder(folder.path())));
  const auto version = current();
  Manifest manifest = source_.manifest();
  manifest.version = 1;
  manifest.previous_master_xxh3.reset();
  LiveWriter writer(source_, *version, rows_);
  BOOST_OUTCOME_TRY(written, writer.write(changed_, folder.path(), options_.threads));
  manifest.tiles.clear();
  for (std::size_t i = 0; i < source_.tiles(); ++i) {
    TileEntry entry = source_.entry(i);
    if (changed_.contains(entry.tile)) continue;
    entry.version = 1;
    BOOST_OUTCOME_TRYV(link_or_copy(source_.file(i), tile_file(folder.path(), entry)));
    manifest.tiles.push_back(entry);
  }
  manifest.tiles.insert(manifest.tiles.end(), written.begin(), written.end());
  describe(manifest, *version);
  BOOST_OUTCOME_TRYV(finish_store(folder.path(), manifest, duplicates_.pairs()));
  BOOST_OUTCOME_TRYV(rename_file(folder.path(), to));
  folder.keep();
  return manifest;
}

// Removed points count as filtered: they were read, and no vertex stands for them.
void LiveResult::describe(Manifest& manifest, const LiveVersion& version) const {
  std::sort(manifest.tiles.begin(), manifest.tiles.end(),
            [](const TileEntry& a, const TileEntry& b) { return a.tile < b.tile; });
  manifest.bounds = {};
  for (const auto& tile : version.tiles()) {
    if (!tile) continue;
    for (const LocalPoint& p : tile->triangulation().own()) manifest.bounds.add(p.at);
  }
  manifest.points_read = next_id_;
  manifest.filtered += filtered_;
  manifest.vertices = manifest.cells = 0;
  for (const TileEntry& entry : manifest.tiles) {
    manifest.vertices += entry.own_points;
    manifest.cells += entry.main_cells;
  }
  manifest.seconds.clear();
  manifest.figures.clear();
  if (!changed_.empty()) manifest.other_heights.reset();  // results do not keep the heights of duplicates
}

}  // namespace tessera
