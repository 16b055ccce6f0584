#include "src/delaunay/run/materialise.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "src/base/files/folder.h"
#include "src/base/files/free_space.h"
#include "src/base/files/temporary.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/base/image.h"
#include "src/base/on_threads.h"
#include "src/base/stopped.h"
#include "src/delaunay/delaunay_program.h"
#include "src/delaunay/disk_store.h"
#include "src/delaunay/run/early.h"
#include "src/delaunay/run/kept_columns.h"
#include "src/delaunay/run/touching.h"
#include "src/exchange/disk_scratch.h"
#include "src/result/new_version.h"
#include "src/result/store/duplicate_rows.h"
#include "src/result/store/early_cells.h"
#include "src/result/tile_queue.h"
#include "src/result/tile_source.h"
#include "src/tiling/partition.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

// The points of the one tile that it is given.
class PointsOfResult final : public TilePoints {
 public:
  explicit PointsOfResult(PointsTile tile) : tile_(std::move(tile)) {}
  int dimension() const override { return tile_.dimension; }
  const std::vector<Attribute>& schema() const override { return tile_.schema; }

  Result<LoadedTile> load(TileId) const override {
    LoadedTile loaded;
    const auto own = static_cast<std::ptrdiff_t>(tile_.own);
    loaded.points.assign(tile_.points.begin(), tile_.points.begin() + own);
    loaded.ids.assign(tile_.ids.begin(), tile_.ids.begin() + own);
    return loaded;
  }

  // The tile's file has the foreign vertices that its cells need.
  Result<std::vector<std::byte>> rows(TileId, std::span<const PointId> ids, std::span<const TileId>) const override {
    const std::size_t width = row_bytes(tile_.schema);
    std::vector<std::byte> rows(ids.size() * width);
    if (width == 0) return rows;
    std::map<PointId, std::size_t> foreign;  // all images of a point have its row
    for (std::size_t i = tile_.own; i < tile_.ids.size(); ++i) foreign[plain(tile_.ids[i])] = i;
    for (std::size_t i = 0; i < ids.size(); ++i) {
      std::size_t from = i;  // own vertices stay where they are
      if (i >= tile_.own) {
        const auto found = foreign.find(ids[i]);
        if (found == foreign.end())
          return error(Errc::internal, "a vertex of a tile's cells is not one of the tile's points");
        from = found->second;
      }
      std::memcpy(&rows[i * width], &tile_.rows[from * width], width);
    }
    return rows;
  }

  Message foreign() const {
    std::vector<SharedPoint> points;
    for (std::size_t i = tile_.own; i < tile_.points.size(); ++i) {
      points.push_back({tile_.points[i], tile_.ids[i], tile_.owners[i], 0});
    }
    const auto bytes = std::as_bytes(std::span(points));
    return {bytes.begin(), bytes.end()};
  }

 private:
  PointsTile tile_;
};

// Makes tiles of a result, each as a job makes it that continues from settled tiles.
class Maker {
 public:
  Maker(TileSource source, fs::path out, std::stop_token stop)
      : source_(std::move(source)),
        out_(std::move(out)),
        stop_(std::move(stop)),
        scratch_({out_, out_, 0, {}, NodeId{0}}) {}

  Status begin() {
    const Manifest& manifest = source_.manifest();
    BOOST_OUTCOME_TRY(partition, Partition::from_json(manifest.partition));
    auto shared = std::make_shared<const Partition>(std::move(partition));
    stage_.dimension = manifest.dimension;
    stage_.early_points = early_points_of(manifest.vertices + manifest.duplicates);
    stage_.early_unit = early_unit(manifest.dimension);
    const Period& period = shared->period();
    stage_.boxes = final_boxes(shared, period);
    stage_.around = std::make_shared<const KnownFromStart>(std::vector<Bounds>(shared->tiles()),
                                                           std::vector<std::vector<TileId>>(shared->tiles()),
                                                           std::vector<Seed>(), period);
    stage_.storage = &scratch_;
    stage_.stop = stop_;
    return success();
  }

  // The file is OUT/tiles/NNNNNN.vtu.
  Result<TileEntry> make(std::size_t index) {
    const TileEntry& kept = source_.entry(index);
    BOOST_OUTCOME_TRYV(source_.check(index));
    BOOST_OUTCOME_TRY(tile, source_.read_as_points(index, {}));
    const KeptColumns columns(tile, source_.manifest().columns);
    const auto points = std::make_shared<const PointsOfResult>(std::move(tile));
    const StoreOptions options{
        .neighbors = source_.manifest().neighbors, .schema = points->schema(), .lock_file = {}, .stop = stop_};
    DiskStore store(points, out_, options, 1, scratch_, nullptr);
    DelaunayStage stage = stage_;
    stage.store = &store;
    DelaunayProgram program(kept.tile, stage);
    BOOST_OUTCOME_TRYV(program.begin_settled(points->foreign()));
    BOOST_OUTCOME_TRY(finished, program.finish());
    std::promise<Result<Receipt>> promise;
    auto stored = promise.get_future();
    finished->store([&](Result<Receipt> receipt) { promise.set_value(std::move(receipt)); });
    BOOST_OUTCOME_TRY(receipt, stored.get());
    auto entry = tile_entry_of(receipt);
    const bool same = entry && entry->points == kept.points && entry->own_points == kept.own_points &&
                      entry->cells == kept.cells && entry->main_cells == kept.main_cells &&
                      (!kept.digest || entry->digest == kept.digest);
    if (!same)
      return error(Errc::corrupt, source_.file(index).string() +
                                      ": its points do not make the cells that the "
                                      "manifest describes");
    BOOST_OUTCOME_TRYV(columns.put_into(tile_file(out_, *entry), *entry, stop_));
    return *entry;
  }

 private:
  TileSource source_;
  fs::path out_;
  std::stop_token stop_;
  DiskScratch scratch_;
  DelaunayStage stage_;
};

std::vector<std::size_t> wanted_tiles(const TileSource& source, const std::optional<Box>& box) {
  std::vector<std::size_t> wanted;
  for (std::size_t i = 0; i < source.tiles(); ++i) {
    const TileEntry& entry = source.entry(i);
    if (entry.kind != TileKind::points) continue;
    bool meets = true;
    for (int axis = 0; box && axis < source.manifest().dimension; ++axis) {
      const Box& tile = source.manifest().boxes.at(entry.tile.value);
      meets &= tile.lo[axis] <= box->hi[axis] && box->lo[axis] <= tile.hi[axis];
    }
    if (meets) wanted.push_back(i);
  }
  return wanted;
}

// Returns about how many bytes the tiles' files take. With columns, each thread also has a file without them for a
// while.
std::uint64_t file_bytes(const TileSource& source, const std::vector<std::size_t>& tiles, unsigned threads) {
  const Manifest& manifest = source.manifest();
  const std::uint64_t cell =
      4 * (static_cast<std::uint64_t>(manifest.dimension) + 1) * (manifest.neighbors ? 2 : 1) + 1;
  std::uint64_t bytes = 0, largest = 0;
  for (const std::size_t i : tiles) {
    const TileEntry& entry = source.entry(i);
    const std::uint64_t of_tile = entry.cells * (cell + row_bytes(cell_schema_of(manifest))) +
                                  entry.points * (33 + row_bytes(manifest.schema)) + (16 << 10);
    bytes += of_tile;
    largest = std::max(largest, of_tile);
  }
  return manifest.columns.empty() ? bytes : bytes + threads * largest;
}

// `take`: is called by several threads, once for each tile.
Status make_tiles(const TileSource& source, const std::vector<std::size_t>& wanted, const fs::path& out,
                  const MaterialiseOptions& options, const std::stop_token& stop,
                  const std::function<Status(std::size_t, const TileEntry&)>& take) {
  BOOST_OUTCOME_TRYV(
      check_room(out, "files of cells", file_bytes(source, wanted, options.threads), known_free_bytes(out)));
  Maker maker(source, out, stop);
  BOOST_OUTCOME_TRYV(maker.begin());
  TileQueue queue(source, wanted, stop, options.progress);
  std::atomic<bool> failed{false};
  // A tile needs memory for a kernel and the file's arrays beside its mesh.
  const unsigned threads = queue.threads(options.threads, options.memory_bytes, 1.5, 0);
  try {
    return on_threads(threads, failed, [&]() -> Status {
      while (!failed) {
        BOOST_OUTCOME_TRY(next, queue.next());
        if (!next) break;
        BOOST_OUTCOME_TRY(entry, maker.make(*next));
        BOOST_OUTCOME_TRYV(take(*next, entry));
        queue.done();
      }
      return success();
    });
  } catch (const Stopped&) {
    return error(Errc::interrupted, "interrupted while cells were made");
  }
}

Result<Materialised> in_place(const fs::path& result, const MaterialiseOptions& options, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(next, NewVersion::begin(result, {.lock = {}, .keep = {}, .periods = Periods::known}));
  const TileSource& source = next->source();
  const auto wanted = wanted_tiles(source, options.box);
  Materialised made{.folder = result, .version = next->number(), .tiles = wanted.size()};
  if (wanted.empty()) {
    made.version = source.manifest().version;
    return made;
  }
  std::mutex mutex;
  BOOST_OUTCOME_TRYV(make_tiles(
      source, wanted, next->scratch(), options, stop, [&](std::size_t index, const TileEntry& entry) -> Status {
        BOOST_OUTCOME_TRYV(next->replace_tile(index, entry, tile_file(next->scratch(), entry)));
        const std::lock_guard lock(mutex);
        made.bytes += entry.bytes;
        return success();
      }));
  BOOST_OUTCOME_TRYV(
      next->commit({}, {.inputs = {}, .command = options.command, .software_version = options.software_version}));
  return made;
}

constexpr std::uint64_t sort_bytes = std::uint64_t{64} << 20;  // for the attributes of duplicates

// Makes a hard link, or a copy where the file system has no hard links.
Status copy_tile(const fs::path& from, const fs::path& to) {
  if (::link(from.c_str(), to.c_str()) == 0) return success();
  BOOST_OUTCOME_TRY(bytes, read_whole(from));
  return write_whole(to, bytes);
}

Result<Materialised> into_folder(const fs::path& result, const MaterialiseOptions& options,
                                 const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(source, TileSource::open(result, Periods::known));
  BOOST_OUTCOME_TRY(there, is_there(options.to));
  if (there) return error(Errc::usage, options.to.string() + ": exists already");
  Materialised made{.folder = options.to};
  BOOST_OUTCOME_TRY(folder, TemporaryFolder::make(temporary_name_of_process(options.to)));
  BOOST_OUTCOME_TRYV(make_directories(tiles_folder(folder.path())));
  Manifest manifest = source.manifest();
  manifest.previous_master_xxh3.reset();  // a new folder has no previous master file
  if (manifest.columns.empty()) manifest.version = 1;
  const auto wanted = wanted_tiles(source, options.box);
  made.tiles = wanted.size();
  std::mutex mutex;
  BOOST_OUTCOME_TRYV(make_tiles(source, wanted, folder.path(), options, stop,
                                [&](std::size_t index, const TileEntry& entry) -> Status {
                                  const std::lock_guard lock(mutex);
                                  made.bytes += entry.bytes;
                                  manifest.tiles[index] = entry;
                                  return success();
                                }));
  for (std::size_t i = 0; i < source.tiles(); ++i) {
    if (std::binary_search(wanted.begin(), wanted.end(), i)) continue;
    manifest.tiles[i].version = 1;
    BOOST_OUTCOME_TRYV(copy_tile(source.file(i), tile_file(folder.path(), manifest.tiles[i])));
  }
  std::vector<DuplicatePair> pairs;
  std::optional<DuplicateRowSort> rows;
  if (manifest.duplicates_xxh3 != 0) {
    BOOST_OUTCOME_TRY(read, read_duplicates(source.folder(), manifest));
    pairs = std::move(read);
    BOOST_OUTCOME_TRY(kept, DuplicateRows::open(result, manifest));
    if (kept) rows.emplace(folder.path(), sort_bytes, row_bytes(carried_schema(manifest)));
    for (std::size_t i = 0; kept && i < pairs.size(); ++i) {
      BOOST_OUTCOME_TRYV(rows->push(pairs[i].duplicate, kept->row(i)));
    }
  }
  BOOST_OUTCOME_TRYV(finish_store(folder.path(), manifest, pairs, rows ? &*rows : nullptr));
  BOOST_OUTCOME_TRYV(rename_file(folder.path(), options.to));
  folder.keep();
  return made;
}

}  // namespace

Result<Materialised> materialise(const fs::path& result, const MaterialiseOptions& options, std::stop_token stop) {
  auto made = options.to.empty() ? in_place(result, options, stop) : into_folder(result, options, stop);
  if (!made) return made.error();
  BOOST_OUTCOME_TRY(source, TileSource::open(made.value().folder, Periods::known));
  const auto& tiles = source.manifest().tiles;
  made.value().left_as_points = static_cast<std::uint64_t>(
      std::count_if(tiles.begin(), tiles.end(), [](const auto& entry) { return entry.kind == TileKind::points; }));
  return made;
}

}  // namespace tessera
