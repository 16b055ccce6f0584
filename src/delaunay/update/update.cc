#include "src/delaunay/update/update.h"

#include <algorithm>
#include <utility>

#include "src/base/check.h"
#include "src/base/files/folder.h"
#include "src/base/files/temporary.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/base/stopped.h"
#include "src/base/too_large.h"
#include "src/delaunay/run/touching.h"
#include "src/delaunay/update/update_exchange.h"
#include "src/delaunay/update/update_plan.h"
#include "src/delaunay/update/updated_result.h"
#include "src/delaunay/update/woken_tile.h"
#include "src/result/measure/made_again.h"
#include "src/result/tile_source.h"
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

// If one tile is flat at the end, all are (docs/updates-design.md).
Status check_span(const TileSource& source, const UpdatedResult::Tiles& tiles) {
  const bool flat =
      std::any_of(tiles.begin(), tiles.end(), [](const auto& t) { return t.second->awake() && t.second->flat(); });
  if (!flat) return success();
  return error(Errc::usage, source.folder().string() + ": the points that would be left all lie " +
                                (source.manifest().dimension == 3 ? "in a plane" : "on a line") +
                                ", so they have no triangulation");
}

// Told bits save messages between tiles that touch.
KnownFromStart known_from_start(const Partition& partition) {
  std::vector<Bounds> bounds(partition.tiles());
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    bounds[i].add(partition.boxes()[i].lo);
    bounds[i].add(partition.boxes()[i].hi);
  }
  const auto neighbours = touching_tiles(partition, bounds);
  KnownFromStart around(std::move(bounds), neighbours, std::vector<Seed>{});
  around.leave_out_fresh_bit();
  return around;
}

// What is changed. A result that is itself changed is locked.
struct Target {
  std::unique_ptr<NewVersion> version;  // null for a new folder, and in a dry run
  TileSource source;
};

Result<Target> open_target(const fs::path& result, const UpdateOptions& options) {
  if (options.dry_run || !options.to.empty()) {
    BOOST_OUTCOME_TRY(source, TileSource::open(result));
    return Target{nullptr, std::move(source)};
  }
  BOOST_OUTCOME_TRY(version, NewVersion::begin(result, options.version));
  const TileSource source = version->source();
  return Target{std::move(version), source};
}

// Both return the manifest of the new result.
Result<Manifest> write_folder(const UpdateSetting& setting, UpdatedResult::Tiles& tiles, const ResultChange& change,
                              const UpdateOptions& options) {
  BOOST_OUTCOME_TRY(folder, TemporaryFolder::make(temporary_name_of_process(options.to)));
  BOOST_OUTCOME_TRYV(make_directories(tiles_folder(folder.path())));
  UpdatedResult next(setting, tiles, folder.path());
  BOOST_OUTCOME_TRYV(next.write_changed(options.threads));
  BOOST_OUTCOME_TRYV(next.link_others());
  BOOST_OUTCOME_TRYV(next.finish(change, options));
  BOOST_OUTCOME_TRYV(rename_file(folder.path(), options.to));
  folder.keep();
  return next.manifest();
}

Result<Manifest> write_version(const UpdateSetting& setting, UpdatedResult::Tiles& tiles, NewVersion& version,
                               const ResultChange& change, const UpdateOptions& options) {
  UpdatedResult next(setting, tiles, version.scratch());
  BOOST_OUTCOME_TRYV(next.write_changed(options.threads));
  BOOST_OUTCOME_TRYV(next.commit(version, change, options));
  return version.manifest();
}

Result<Updated> update(const fs::path& result, const ResultChange& change, const UpdateOptions& options,
                       const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(target, open_target(result, options));
  const TileSource source = target.source.without_columns().stopped_by(stop);
  if (change.chosen_from != 0 && change.chosen_from != source.manifest().version)
    return error(Errc::usage, result.string() +
                                  ": another program has changed the result meanwhile; run the command "
                                  "again, so that points are chosen from the present version");
  if (!options.dry_run && !options.to.empty()) {
    if (options.to.empty()) return error(Errc::usage, result.string() + ": no folder for the new result is given");
    BOOST_OUTCOME_TRY(there, is_there(options.to));
    if (there) return error(Errc::usage, options.to.string() + ": exists already");
  }
  BOOST_OUTCOME_TRYV(check_changeable(result, target.source.manifest()));
  if (!options.to.empty() && !target.source.manifest().columns.empty())
    return error(Errc::usage, result.string() + ": has the computed column '" +
                                  target.source.manifest().columns[0].name +
                                  "', which only a change of the result itself makes again, not one into a new folder");
  BOOST_OUTCOME_TRYV(check_points(change, source.manifest()));
  BOOST_OUTCOME_TRY(partition, Partition::from_json(source.manifest().partition));
  BOOST_OUTCOME_TRY(plan, plan_update(source, partition, change));
  if (plan.removed.size() == source.manifest().vertices && plan.heirs.empty() && plan.added.empty())
    return error(Errc::usage, result.string() + ": no points would be left");
  const KnownFromStart around = known_from_start(partition);
  const UpdateSetting setting{source, plan, around, change.rows, stop};

  UpdateExchange exchange(setting, options.threads);
  BOOST_OUTCOME_TRYV(exchange.run());
  Updated updated{.first_new = plan.first_new, .removed = plan.removed_points, .duplicates = plan.new_equal};
  for (const auto& [id, tile] : exchange.tiles()) {
    updated.begun += tile->begins() ? 1 : 0;
    updated.awake += tile->awake() ? 1 : 0;
    updated.duplicates += tile->duplicates().size();
    updated.written += tile->awake() && tile->changed() ? 1 : 0;
    updated.exchange += tile->counts();
  }
  BOOST_OUTCOME_TRYV(check_span(source, exchange.tiles()));
  if (options.dry_run) return updated;
  BOOST_OUTCOME_TRY(made, target.version ? write_version(setting, exchange.tiles(), *target.version, change, options)
                                         : write_folder(setting, exchange.tiles(), change, options));
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
  const auto dear = std::ranges::find_if_not(manifest.columns, can_be_made_again);
  if (dear != manifest.columns.end())
    return refuse("the result has the computed column '" + dear->name +
                  "', which depends on more than cells and would not be right afterwards; change the result as it was "
                  "before this column was computed");
  const bool rows_missing =
      manifest.duplicates_xxh3 != 0 && manifest.duplicate_rows_xxh3 == 0 && !manifest.schema.empty();
  if (manifest.keep != DuplicatePolicy::first && rows_missing)
    return refuse("the " + std::string(name_of(manifest.keep)) +
                  " of equal points is the vertex of this result, and results of older software do not keep the "
                  "attributes of the other points; triangulate again");
  return success();
}

Result<Updated> update_result(const fs::path& result, const ResultChange& change, const UpdateOptions& options,
                              std::stop_token stop) {
  try {
    return update(result, change, options, stop);
  } catch (const Stopped&) {
    return error(Errc::interrupted, "interrupted while " + result.string() + " was changed");
  } catch (const TileTooLarge& e) {
    return error(Errc::memory, result.string() + ": a tile " + e.what());
  }
}

}  // namespace tessera
