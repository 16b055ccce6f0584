#include "src/delaunay/update/update.h"

#include <algorithm>
#include <functional>
#include <memory>
#include <random>
#include <set>
#include <span>
#include <utility>

#include "src/base/check.h"
#include "src/base/files/checksum.h"
#include "src/base/files/free_space.h"
#include "src/base/files/names.h"
#include "src/base/files/temporary.h"
#include "src/base/files/there.h"
#include "src/base/files/update_names.h"
#include "src/base/files/whole_file.h"
#include "src/base/flat_codec.h"
#include "src/base/ledger.h"
#include "src/base/stopped.h"
#include "src/base/too_large.h"
#include "src/delaunay/run/result_stages.h"
#include "src/delaunay/run/run_folder.h"
#include "src/delaunay/update/anew.h"
#include "src/delaunay/update/change_estimate.h"
#include "src/delaunay/update/grown_tiles.h"
#include "src/delaunay/update/made_mark.h"
#include "src/delaunay/update/update_folder.h"
#include "src/delaunay/update/update_plan.h"
#include "src/delaunay/update/update_stages.h"
#include "src/delaunay/update/updated_result.h"
#include "src/result/far_files.h"
#include "src/result/measure/made_again.h"
#include "src/result/new_version.h"
#include "src/result/tile_source.h"
#include "src/result/version_log.h"
#include "src/tiling/partition.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

Status check_points(const ResultChange& change, const Manifest& manifest) {
  check(change.rows.size() == change.add.size() * row_bytes(manifest.schema), "every new point has its attributes");
  for (std::size_t i = 0; i < change.add.size(); ++i) {
    if (!is_finite(change.add[i]))
      return error(Errc::usage, "new point " + std::to_string(i) + " has a coordinate that is not finite");
    check(manifest.dimension == 3 || change.add[i].z == 0, "in 2D z is 0");
  }
  return success();
}

std::string checksum_of_tiles(const Manifest& manifest) {
  FlatWriter all;
  for (const TileEntry& tile : manifest.tiles) {
    all.value(tile.tile.value);
    all.value(tile.own_points);
    all.value(tile.xxh3);
  }
  return checksum_text(checksum(all.take()));
}

// What a change is made of, once all is checked. A result that is itself changed is locked.
struct Wanted {
  std::unique_ptr<NewVersion> version;  // null for a new folder, and in a dry run
  TileSource whole;                     // with columns
  TileSource source;                    // without columns
  Partition partition;
  UpdatePlan plan;
  bool anew = false;
};

bool most_tiles_begin(const TileSource& source, const UpdatePlan& plan) {
  return source.tiles() > 1 && tiles_that_begin(plan).size() * 2 > source.tiles();
}

// Makes sure that the run has its plan: that of an earlier process, or a new one.
Status begin_run(const fs::path& run, const Wanted& wanted, const UpdateOptions& options, const std::stop_token& stop) {
  const Manifest& manifest = wanted.source.manifest();
  const auto change = bytes_of(wanted.plan);
  UpdateJob job{.result = manifest.digest ? digest_text(*manifest.digest) : "",
                .tiles = checksum_of_tiles(manifest),
                .change = checksum_text(checksum(change)),
                .added = {},
                .writes = !options.dry_run,
                .anew = {},
                .number = std::uint64_t{std::random_device()()} << 32u | std::random_device()()};
  for (const auto& [tile, points] : wanted.plan.added) job.added[tile] = points.size();
  const fs::path file = plan_file(run);
  BOOST_OUTCOME_TRY(there, is_there(file));
  if (options.resume && there) {
    BOOST_OUTCOME_TRY(bytes, read_whole(file));
    BOOST_OUTCOME_TRY(earlier, read_update_job(bytes, file.string()));
    job.number = earlier.number;
    job.anew = earlier.anew;
    if (wanted.anew != earlier.anew.empty() && to_json(job) == as_text(bytes)) return success();
    return error(Errc::usage, run.string() + ": cannot be resumed: the unfinished run was started with " +
                                  (job.result != earlier.result || job.tiles != earlier.tiles ? "another result"
                                                                                              : "another change"));
  }
  if (wanted.anew) {
    BOOST_OUTCOME_TRY(
        start, find_anew_start(wanted.source, wanted.partition, wanted.plan, std::max(options.threads, 1u), stop));
    const auto bytes = bytes_of(start);
    job.anew = checksum_text(checksum(bytes));
    BOOST_OUTCOME_TRYV(write_whole(update_anew_file(run), bytes));
  }
  BOOST_OUTCOME_TRYV(write_whole(update_change_file(run), change));
  return write_whole(file, to_json(job));
}

// When all tiles are triangulated, those without points leave nothing.
void add_emptied(const TileSource& source, UpdatedResult::Ends& ends) {
  for (const TileEntry& entry : source.manifest().tiles) {
    TileEnd& end = ends[entry.tile];
    end.changed = end.lost = true;
    end.removed_bounds = source.manifest().bounds;  // so that all bounds are those of the tiles' vertices
  }
}

Result<UpdatedResult::Ends> gather(const fs::path& run, const Wanted& wanted) {
  BOOST_OUTCOME_TRY(plan, read_whole(plan_file(run)));
  const std::uint64_t seal = seal_of_plan(plan);
  BOOST_OUTCOME_TRY(tiles, tiles_in(update_ends_folder(run)));
  UpdatedResult::Ends ends;
  for (const TileId tile : tiles) {
    BOOST_OUTCOME_TRY(end, read_end(run, seal, tile));
    ends[tile] = std::move(end);
  }
  if (wanted.anew) add_emptied(wanted.source, ends);
  return ends;
}

Updated counted(const UpdatedResult::Ends& ends, const Wanted& wanted) {
  Updated updated{.first_new = wanted.plan.first_new,
                  .removed = wanted.plan.removed_points,
                  .duplicates = wanted.plan.new_equal,
                  .anew = wanted.anew};
  for (const auto& [tile, end] : ends) {
    updated.begun += end.begun ? 1 : 0;
    updated.awake += end.awake ? 1 : 0;
    updated.duplicates += end.duplicates.size();
    updated.written += end.awake && end.changed ? 1 : 0;
    updated.exchange += end.counts;
    const auto old = wanted.source.find(tile);
    if (end.changed && old) updated.old_bytes += wanted.source.entry(*old).bytes;
    if (end.awake && old) updated.old_points += wanted.source.entry(*old).own_points;
  }
  return updated;
}

// Nodes and the engine's threads have written these files, which the ledger of this thread may not know.
Status draw_files(const UpdatedResult::Ends& ends) {
  Ledger* const ledger = Ledger::of_thread();
  if (ledger == nullptr) return success();
  std::uint64_t bytes = 0;
  for (const auto& [tile, end] : ends) bytes += end.entry ? end.entry->bytes : 0;
  return ledger->written_by_others(bytes);
}

struct Target {
  std::unique_ptr<NewVersion> version;
  TileSource source;
};

Result<Target> open_target(const fs::path& result, const UpdateOptions& options) {
  BOOST_OUTCOME_TRYV(result::refuse_far(result));
  if (options.dry_run || !options.to.empty()) {
    BOOST_OUTCOME_TRY(source, TileSource::open(result));
    return Target{nullptr, std::move(source)};
  }
  BOOST_OUTCOME_TRY(version, NewVersion::begin(result, options.version));
  const TileSource source = version->source();
  return Target{std::move(version), source};
}

// `source`: with the columns of the result.
Status check_target(const fs::path& result, const TileSource& source, const ResultChange& change,
                    const UpdateOptions& options) {
  const Manifest& manifest = source.manifest();
  if (change.chosen_from != 0 && change.chosen_from != manifest.version)
    return error(Errc::usage, result.string() +
                                  ": another program has changed the result meanwhile; run the command again, so that "
                                  "points are chosen from the present version");
  if (!options.dry_run && !options.to.empty()) {
    BOOST_OUTCOME_TRY(there, is_there(options.to));
    if (there) return error(Errc::usage, options.to.string() + ": exists already");
  }
  return check_changeable(result, manifest);
}

Result<Wanted> plan_change(const fs::path& result, const ResultChange& change, const UpdateOptions& options,
                           const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(target, open_target(result, options));
  BOOST_OUTCOME_TRYV(check_target(result, target.source, change, options));
  TileSource source = target.source.without_columns().stopped_by(stop);
  BOOST_OUTCOME_TRYV(check_points(change, source.manifest()));
  BOOST_OUTCOME_TRY(partition, Partition::from_json(source.manifest().partition));
  BOOST_OUTCOME_TRY(plan, plan_update(source, partition, change, options.threads));
  if (!plan.common) return error(Errc::usage, result.string() + ": no points would be left");
  const bool anew =
      options.way == UpdateWay::anew || (options.way == UpdateWay::cheapest && most_tiles_begin(source, plan));
  return Wanted{std::move(target.version), target.source.stopped_by(stop),
                std::move(source),         std::move(partition),
                std::move(plan),           anew};
}

// The stages open the result by its path, perhaps when there is a newer version.
fs::path path_of(const TileSource& source) { return version_file(source.folder(), source.manifest().version); }

const char* kind_of(const Wanted& wanted) {
  return wanted.anew || wanted.plan.removed.empty() ? kind_of_update : kind_of_update_with_holes;
}

Result<Updated> try_update(const Wanted& wanted, const UpdateOptions& options, StagesRunner& runner,
                           const std::stop_token& stop) {
  if (wanted.anew) {
    Updated updated = counted({}, wanted);
    updated.begun = updated.awake = updated.written = wanted.source.tiles();
    updated.old_points = wanted.source.manifest().vertices;
    for (const TileEntry& entry : wanted.source.manifest().tiles) updated.old_bytes += entry.bytes;
    return updated;
  }
  const ChangeEstimate estimate = estimate_change(wanted.source, wanted.partition, wanted.plan);
  if (estimate.begun_points > options.dry_points) {
    Updated updated = counted({}, wanted);
    updated.estimated = true;
    updated.begun = estimate.begun;
    updated.awake = updated.written = estimate.awake;
    updated.old_points = estimate.points;
    updated.old_bytes = estimate.bytes;
    return updated;
  }
  BOOST_OUTCOME_TRY(run, options.run.empty() ? TemporaryFolder::make() : TemporaryFolder::make(options.run));
  BOOST_OUTCOME_TRYV(begin_run(run.path(), wanted, options, stop));
  BOOST_OUTCOME_TRYV(runner.run(kind_of(wanted), path_of(wanted.source), run.path(), {}, options.progress, stop));
  BOOST_OUTCOME_TRY(ends, gather(run.path(), wanted));
  return counted(ends, wanted);
}

// The new files, after tiles that have grown too large are split, and the partition that goes with them.
struct Divided {
  ChangedTiles tiles;
  Partition partition;
  std::uint64_t tile_points = 0;
  std::uint64_t split = 0;
};

Result<Divided> divide(const fs::path& run, const Wanted& wanted, UpdatedResult::Ends ends,
                       const UpdateOptions& options, const std::stop_token& stop) {
  Divided divided{.tiles = {std::move(ends), update_result_folder(run)},
                  .partition = wanted.partition,
                  .tile_points = limit_of_tiles(wanted.source.manifest(), options.tile_points)};
  BOOST_OUTCOME_TRYV(make_directories(tiles_folder(divided.tiles.folder)));
  GrownTiles grown(wanted.source, divided.tiles, stop);
  BOOST_OUTCOME_TRY(split, grown.split(divided.partition, divided.tile_points));
  divided.split = split.size();
  if (split.empty()) return divided;
  BOOST_OUTCOME_TRY(tiles, grown.write(divided.partition, split, update_split_folder(run)));
  divided.tiles = std::move(tiles);
  return divided;
}

// The run folder of a change that is written.
fs::path run_of(const fs::path& result, const UpdateOptions& options) {
  return options.run.empty() ? update_run_folder(options.to.empty() ? result : options.to) : options.run;
}

// Counts what is written at least: files of the tiles with new or removed points, of the points that they will have.
// Tiles that these wake may come on top.
std::uint64_t bytes_at_least(const Wanted& wanted, const ResultChange& change) {
  const Manifest& manifest = wanted.source.manifest();
  const auto removed = static_cast<double>(wanted.plan.removed.size());
  double bytes = 0, all = 0;
  const std::set<TileId> begin = tiles_that_begin(wanted.plan);
  for (const TileEntry& entry : manifest.tiles) {
    all += static_cast<double>(entry.bytes);
    const auto own = static_cast<double>(entry.own_points);
    if (own > 0 && begin.contains(entry.tile))
      bytes += static_cast<double>(entry.bytes) * std::max(0.0, own - removed) / own;
  }
  const auto vertices = static_cast<double>(std::max<std::uint64_t>(manifest.vertices, 1));
  const double of_a_point = all / vertices;
  if (wanted.anew) bytes = of_a_point * std::max(0.0, vertices - removed);
  return static_cast<std::uint64_t>(bytes + of_a_point * static_cast<double>(change.add.size()));
}

// A run that goes on has written a part already.
Status check_disk(const fs::path& run, const Wanted& wanted, const ResultChange& change, const UpdateOptions& options) {
  BOOST_OUTCOME_TRY(begun, is_there(plan_file(run)));
  if (options.resume && begun) return success();
  const fs::path disk = run.has_parent_path() ? run.parent_path() : fs::path(".");
  const auto free = known_free_bytes(disk);
  const std::uint64_t needed = bytes_at_least(wanted, change);
  if (!free || *free >= needed) return success();
  return error(Errc::io, wanted.source.folder().string() + ": the changed tiles need at least about " +
                             std::to_string((needed >> 20) + 1) + " MiB beside the old ones, and the disk has " +
                             std::to_string(*free >> 20) + " MiB left");
}

// Whether the run has noted tiles whose files are gone. A process that was killed while it made the new version has
// moved files into the result, and the next change of the result has removed them there.
Result<bool> lacks_files(const fs::path& run) {
  BOOST_OUTCOME_TRY(begun, is_there(plan_file(run)));
  if (!begun) return false;
  BOOST_OUTCOME_TRY(plan, read_whole(plan_file(run)));
  BOOST_OUTCOME_TRY(job, read_update_job(plan, plan_file(run).string()));
  if (!job.writes) return false;
  BOOST_OUTCOME_TRY(tiles, tiles_in(update_ends_folder(run)));
  for (const TileId tile : tiles) {
    BOOST_OUTCOME_TRY(end, read_end(run, seal_of_plan(plan), tile));
    if (!end.entry) continue;
    BOOST_OUTCOME_TRY(there, is_there(tile_file(update_result_folder(run), *end.entry)));
    if (!there) return true;
  }
  return false;
}

// The folder of a new run, or of one that can go on.
Result<RunFolder> claim_run(const fs::path& run, const UpdateOptions& options) {
  constexpr const char* what = "the new result";
  if (options.resume) {
    BOOST_OUTCOME_TRY(lacks, lacks_files(run));
    if (lacks) {
      BOOST_OUTCOME_TRY(useless, RunFolder::claim(run, what, false, options.lock));  // empties it
      useless.done();
    }
  }
  return RunFolder::claim(run, what, options.resume, options.lock);
}

Updated unchanged(const Wanted& wanted) {
  const Manifest& manifest = wanted.source.manifest();
  return {.first_new = wanted.plan.first_new,
          .vertices = manifest.vertices,
          .cells = manifest.cells,
          .tiles = manifest.tiles.size(),
          .version = manifest.version,
          .digest = manifest.digest,
          .unchanged = true};
}

// Returns the manifest of the new result.
Result<Manifest> store(const fs::path& run, const Wanted& wanted, const Divided& divided, const ResultChange& change,
                       const UpdateOptions& options, const std::stop_token& stop) {
  UpdatedResult next({wanted.whole, wanted.source, wanted.plan, divided.tiles.ends, divided.partition,
                      divided.tile_points, change, options},
                     divided.tiles.folder, update_columns_folder(run), stop);
  if (wanted.version) {
    BOOST_OUTCOME_TRYV(next.commit(*wanted.version, [&](const std::string& manifest) {
      const auto bytes = std::as_bytes(std::span(manifest));
      return write_mark(run, {checksum_text(checksum(bytes)), options.command});
    }));
    return wanted.version->manifest();
  }
  BOOST_OUTCOME_TRYV(next.link_others());
  BOOST_OUTCOME_TRYV(next.finish());
  BOOST_OUTCOME_TRY(sum, checksum_file(manifest_file(next.target())));
  BOOST_OUTCOME_TRYV(write_mark(run, {checksum_text(sum), options.command}));
  BOOST_OUTCOME_TRYV(rename_file(next.target(), options.to));
  return next.manifest();
}

Result<Updated> update(const fs::path& result, const ResultChange& change, const UpdateOptions& options,
                       StagesRunner& runner, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(wanted, plan_change(result, change, options, stop));
  if (options.dry_run) return try_update(wanted, options, runner, stop);
  if (wanted.version && change.add.empty() && wanted.plan.removed_points == 0) return unchanged(wanted);
  const fs::path run_path = run_of(result, options);
  BOOST_OUTCOME_TRYV(check_disk(run_path, wanted, change, options));
  BOOST_OUTCOME_TRY(run, claim_run(run_path, options));
  BOOST_OUTCOME_TRYV(begin_run(run.path(), wanted, options, stop));
  BOOST_OUTCOME_TRYV(
      runner.run(kind_of(wanted), path_of(wanted.source), run.path(), run.lock_file(), options.progress, stop));
  BOOST_OUTCOME_TRY(ends, gather(run.path(), wanted));
  BOOST_OUTCOME_TRYV(draw_files(ends));
  Updated updated = counted(ends, wanted);
  BOOST_OUTCOME_TRY(divided, divide(run.path(), wanted, std::move(ends), options, stop));
  updated.split = divided.split;
  BOOST_OUTCOME_TRY(made, store(run.path(), wanted, divided, change, options, stop));
  run.done();
  updated.vertices = made.vertices;
  updated.cells = made.cells;
  updated.tiles = made.tiles.size();
  updated.version = made.version;
  updated.digest = made.digest;
  return updated;
}

}  // namespace

Status check_changeable(const fs::path& result, const Manifest& manifest) {
  const auto refuse = [&](const std::string& why) { return error(Errc::usage, result.string() + ": " + why); };
  if (manifest.format_version < unchanged_format)
    return refuse("is of format version " + std::to_string(manifest.format_version) +
                  ", which is read and not changed; triangulate again");
  if (manifest.region) return refuse("the result is a region of a cloud, and only whole results can be changed");
  BOOST_OUTCOME_TRYV(check_can_be_made_again(result, manifest));
  const bool rows_missing =
      manifest.duplicates_xxh3 != 0 && manifest.duplicate_rows_xxh3 == 0 && !manifest.schema.empty();
  if (manifest.keep != DuplicatePolicy::first && rows_missing)
    return refuse("the " + std::string(name_of(manifest.keep)) +
                  " of equal points is the vertex of this result, and results of older software do not keep the "
                  "attributes of the other points; triangulate again");
  return success();
}

Result<std::optional<VersionEntry>> finish_earlier(
    const fs::path& result, const UpdateOptions& options,
    const std::function<bool(const std::vector<std::string>& command)>& is_same) {
  if (!options.resume || options.dry_run) return std::optional<VersionEntry>();
  const fs::path run = run_of(result, options), out = options.to.empty() ? result : options.to;
  BOOST_OUTCOME_TRY(mark, read_mark(run));
  if (!mark) return std::optional<VersionEntry>();
  BOOST_OUTCOME_TRY(made, is_made(*mark, out));
  if (!made) return std::optional<VersionEntry>();
  BOOST_OUTCOME_TRY(manifest, read_manifest(out));
  if (!is_same(mark->command)) {
    std::string words;
    for (const std::string& word : mark->command) words += (words.empty() ? "" : " ") + word;
    return error(Errc::usage, run.string() + ": is left of another command, which has made version " +
                                  std::to_string(manifest.version) + " of " + out.string() + ": '" + words +
                                  "'; there is nothing to continue");
  }
  VersionEntry entry = entry_of(manifest, 0);
  if (options.to.empty()) {
    BOOST_OUTCOME_TRYV(mend_master(out, options.version.lock));
    BOOST_OUTCOME_TRY(told, tell_versions(out));
    if (!told.versions.empty() && told.versions.back().entry.version == entry.version)
      entry = std::move(told.versions.back().entry);
  }
  BOOST_OUTCOME_TRY(left, RunFolder::claim(run, "the new result", false, options.lock));  // removes what is left
  left.done();
  return std::optional(std::move(entry));
}

Result<Updated> update_result(const fs::path& result, const ResultChange& change, const UpdateOptions& options,
                              StagesRunner& runner, std::stop_token stop) {
  try {
    return update(result, change, options, runner, stop);
  } catch (const Stopped&) {
    return error(Errc::interrupted, "interrupted while " + result.string() + " was changed");
  } catch (const TileTooLarge& e) {
    return error(Errc::memory, result.string() + ": a tile " + e.what());
  }
}

}  // namespace tessera
