// Changes a stored result: removes points and adds others. The new result is the one that a triangulation of the points
// that are left would be, with the same source indices (docs/updates-design.md). Only tiles whose triangulation may
// change are read, and only tiles that have changed are written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/figures.h"
#include "src/base/files/folder_lock.h"
#include "src/base/point.h"
#include "src/base/result.h"
#include "src/delaunay/run/stages_runner.h"
#include "src/result/new_version.h"
#include "src/result/store/digest.h"
#include "src/result/store/tile_store.h"
#include "src/result/version_log.h"

namespace tessera {

struct ResultChange {
  // The new points. Their source indices go on where those of the result end. In 2D z is 0.
  std::vector<Point> add = {};
  std::vector<std::byte> rows = {};  // of the new points, in the schema of the result
  std::vector<PointId> remove = {};  // source indices of vertices and duplicates
  // The version of the result in which the points to be removed were found. 0: they were not chosen from a version.
  std::uint32_t chosen_from = 0;
};

// How the cells of a changed result are found (docs/updates-design.md). The result is the same.
enum class UpdateWay : std::uint8_t {
  cheapest,  // exchange, unless most tiles have fresh points
  exchange,  // tiles with fresh points begin, and wake those whose cells may change
  anew       // all tiles are triangulated as in a first triangulation
};

struct UpdateOptions {
  // The folder of the new result, which must not exist. Empty: the result itself gets a new version.
  std::filesystem::path to = {};
  VersionOptions version = {};  // of a change of the result itself
  unsigned threads = 1;         // that read source indices
  // Whether to continue what an earlier process has begun, and to leave what is done when this process is interrupted.
  bool resume = false;
  // The run folder, in the file system of the new result; in a dry run it must not exist. Empty: update_run_folder() of
  // the new result, and in a dry run a temporary folder.
  std::filesystem::path run = {};
  LockOptions lock = {};
  std::function<void(double)> progress = {};  // is told how much is done, from 0 to 1
  UpdateWay way = UpdateWay::cheapest;
  // A tile with more points is split (grown_tiles.h). 0: as an earlier change has said, else by the largest tile.
  std::uint64_t tile_points = 0;
  bool dry_run = false;  // only find out what would change
  // If tiles with new or removed points have more old points than this together, a dry run estimates what would change,
  // because the exchange of so many tiles takes long.
  std::uint64_t dry_points = 2'000'000;
  std::vector<std::string> command = {};  // for the manifest, and for the log of versions
  // The manifest keeps the command that made the result, and only the log gets the new one.
  bool keep_command = false;
  std::string software_version = {};  // for the manifest
  // Of the new points, for the manifest. Their source indices count from 0, the first new point.
  std::vector<Manifest::Input> inputs = {};
};

struct Updated {
  std::uint64_t first_new = 0;                       // the source index of the first new point
  std::uint64_t removed = 0;                         // points: vertices and duplicates
  std::uint64_t duplicates = 0;                      // new points that are equal to others
  std::uint64_t vertices = 0, cells = 0, tiles = 0;  // of the new result; 0 in a dry run
  std::uint32_t version = 1;                         // of the new result
  // Tiles that had fresh points; that were triangulated; and of these, those that have changed.
  std::uint64_t begun = 0, awake = 0, written = 0;
  bool anew = false;  // all tiles were triangulated
  // A dry run has counted the tiles with new or removed points, and all that touch them, instead of the following ones.
  bool estimated = false;
  std::uint64_t split = 0;  // tiles that had grown too large and were split
  // As the result was: own points of the tiles that were triangulated, and the bytes of the files of those that have
  // changed.
  std::uint64_t old_points = 0, old_bytes = 0;
  ExchangeCounts exchange = {};
  std::optional<Digest> digest = {};  // of the new result
  // No point was to be added or removed, so the result itself has no new version. A new folder is made nevertheless.
  bool unchanged = false;
};

// Looks for a run that has made its result, but ended before it had removed its run folder, and removes what is left of
// the run. Call this before the points of a change are chosen, because the new version has other points. Returns what
// the log says of the result that was made; of a new folder, what its manifest says. Nothing without options.resume,
// and when there is no such run. `is_same`: whether the command of that run is the present one. Errors: usage when it
// is not, and when another process works there; corrupt; io.
Result<std::optional<VersionEntry>> finish_earlier(
    const std::filesystem::path& result, const UpdateOptions& options,
    const std::function<bool(const std::vector<std::string>& command)>& is_same);

// Whether a result can be changed at all. Error usage, with the reason, when it cannot.
Status check_changeable(const std::filesystem::path& result, const Manifest& manifest);

// Makes the new result. In a new folder, tiles that have not changed are hard links to the old files, and the old
// result stays as it is. Otherwise the result gets a new version: whoever reads the result keeps the version that he
// has opened, and an end of this process at any moment leaves the old version or the new one. What is made is in the
// run folder until it is whole. A change of the result itself that neither adds nor removes a point does nothing.
// `runner` runs jobs of the kind kind_of_update.
// Errors: usage when the result cannot be changed in this way, when a point to be removed does not exist, when the
// points that are left do not span space, when the folder exists, when another process changes the result, or has
// changed it since points were chosen, or when what an earlier process has begun is another change; io, before anything
// is written, when the disk surely has no room; those of TileSource and of the runner; interrupted. After an error the
// folder does not exist, or the old version stands, and the run folder is gone unless `resume` is set.
Result<Updated> update_result(const std::filesystem::path& result, const ResultChange& change,
                              const UpdateOptions& options, StagesRunner& runner, std::stop_token stop = {});

}  // namespace tessera
