#include "src/job/told_update.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "src/delaunay/update/update.h"
#include "src/job/estimate.h"
#include "src/result/store/digest.h"
#include "src/result/version_log.h"

namespace tessera {

namespace {

using ToldJson = nlohmann::ordered_json;

// The numbers of the new result.
struct NewNumbers {
  std::uint64_t tiles = 0, vertices = 0, cells = 0;
  std::optional<Digest> digest = {};
};

void tell(const NewNumbers& numbers, ToldJson& told) {
  told["tiles"] = numbers.tiles;
  told["vertices"] = numbers.vertices;
  told["cells"] = numbers.cells;
  if (numbers.digest) told["digest"] = digest_text(*numbers.digest);
}

// As the estimate of a triangulation, for the points of the tiles that are triangulated.
double seconds_of(const Updated& updated, const AskedChange& asked) {
  const std::uint64_t limit = updated.old_points / std::max<std::uint64_t>(updated.awake, 1) + 1;
  return estimate(asked.dimension, KernelKind::flat, TileKind::cells, updated.old_points, limit, true, 0,
                  {asked.memory_bytes, asked.threads})
      .seconds;
}

}  // namespace

ToldJson told_of(const Updated& updated, const AskedChange& asked) {
  ToldJson told{{"event", asked.dry_run ? "would_update" : "updated"}};
  if (!asked.dry_run) {
    told["output"] = asked.output;
    told["version"] = updated.version;
  }
  if (updated.unchanged) told["unchanged"] = true;
  told["removed"] = updated.removed;
  told["added"] = asked.added;
  told["first_new_id"] = updated.first_new;
  told["duplicates"] = updated.duplicates;
  told["way"] = updated.anew ? "anew" : "exchange";
  told["tiles_begun"] = updated.begun;
  told["tiles_awake"] = updated.awake;
  told["tiles_changed"] = updated.written;
  told["points_sent"] = updated.exchange.sent;
  if (asked.dry_run) {
    told["estimated"] = updated.estimated;
    told["bytes"] = updated.old_bytes;
    told["seconds"] = seconds_of(updated, asked);
    return told;
  }
  told["tiles_split"] = updated.split;
  tell({updated.tiles, updated.vertices, updated.cells, updated.digest}, told);
  return told;
}

ToldJson told_of_made(const VersionEntry& version, const std::string& output) {
  ToldJson told{{"event", "updated"}, {"output", output}, {"version", version.version}};
  if (version.version > 1) {
    told["removed"] = version.removed;
    told["added"] = version.added;
    told["tiles_changed"] = version.tiles_written;
  }
  tell({version.tiles, version.vertices, version.cells, version.digest}, told);
  return told;
}

}  // namespace tessera
