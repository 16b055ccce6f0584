#include "src/service/processes/update_costs.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "src/delaunay/update/change_estimate.h"
#include "src/delaunay/update/update_plan.h"
#include "src/input/cloud/cloud.h"
#include "src/job/estimate.h"
#include "src/job/new_points.h"
#include "src/job/report/human.h"
#include "src/result/query/hull.h"
#include "src/service/problem.h"
#include "src/service/processes/costs.h"
#include "src/service/processes/polygon_text.h"
#include "src/service/processes/result_costs.h"
#include "src/service/processes/update_inputs.h"
#include "src/tiling/partition.h"

namespace tessera::service {
namespace {

// Some tenths of a second, for which a caller waits.
constexpr std::uint64_t new_points_read_max = 1'000'000;
constexpr std::uint64_t vertices_looked_at_max = 20'000'000;

// What is known of a change before it is made.
struct Concerned {
  UpdatePlan tiles;                                // only which tiles may lose or get points
  std::map<TileId, std::uint64_t> removed_surely;  // points that tiles lose, at least
  std::uint64_t added = 0;                         // points, or about as many
  std::string later = {};                          // what is only known when the job runs
};

bool meet(const Bounds& a, const Bounds& b, int dimension) {
  for (int axis = 0; axis < dimension; ++axis) {
    if (a.lo[axis] > b.hi[axis] || b.lo[axis] > a.hi[axis]) return false;
  }
  return true;
}

class ChangeCosts {
 public:
  ChangeCosts(const Workshop& shop, const proto::UpdateInputs& inputs, const UpdateRequest& request, TileSource source,
              Partition partition)
      : shop_(shop),
        inputs_(inputs),
        request_(request),
        source_(std::move(source)),
        manifest_(source_.manifest()),
        partition_(std::move(partition)) {}

  // Errors: those of reading new points and source indices.
  Status look() {
    if (inputs_.inputs_size() > 0) {
      BOOST_OUTCOME_TRYV(look_at_new_points());
    }
    BOOST_OUTCOME_TRYV(look_at_ids());
    if (request_.selection.box) {
      const Box& box = *request_.selection.box;
      may_lose_in({box.lo, box.hi}, std::isfinite(box.lo.z) ? manifest_.dimension : 2);
    }
    if (inputs_.has_remove_polygon()) {
      BOOST_OUTCOME_TRY(frame, check_polygons("remove-polygon", inputs_.remove_polygon()));
      may_lose_in(frame.bounds, 2);
    }
    if (!request_.selection.classes.empty() || request_.selection.times || inputs_.remove_input_size() > 0)
      may_lose_anywhere("points of a class, a time or an input are found");
    return success();
  }

  proto::Estimate tell() const {
    const ChangeEstimate change = estimate_change(source_, partition_, found_.tiles);
    const bool anew = source_.tiles() > 1 && change.begun * 2 > source_.tiles();
    std::uint64_t all_bytes = 0;
    for (const TileEntry& entry : manifest_.tiles) all_bytes += entry.bytes;
    const std::uint64_t tiles = std::max<std::uint64_t>(anew ? source_.tiles() : change.awake, 1);
    const std::uint64_t points = (anew ? manifest_.vertices : change.points) + found_.added;
    const double of_a_point =
        static_cast<double>(all_bytes) / static_cast<double>(std::max<std::uint64_t>(manifest_.vertices, 1));
    const std::uint64_t bytes =
        (anew ? all_bytes : change.bytes) + static_cast<std::uint64_t>(of_a_point * static_cast<double>(found_.added));
    const auto cost = tessera::estimate(
        manifest_.dimension, KernelKind::flat, TileKind::cells, points, points / tiles + 1, manifest_.neighbors, 0,
        {.memory_bytes = request_.share.memory_bytes, .threads = request_.share.threads});
    proto::Estimate told;
    told.set_points(points);
    told.set_cells(cost.cells);
    told.set_tiles(tiles);
    told.set_memory_bytes(cost.memory_bytes);
    told.set_seconds(cost.seconds);
    told.set_result_bytes(inputs_.dry_run() ? 0 : bytes);
    // With columns each file is made without them first.
    told.set_temporary_bytes(plan_bytes() + (inputs_.dry_run() || manifest_.columns.empty() ? 0 : bytes));
    told.set_reason(found_.later);
    return told;
  }

  std::optional<proto::Problem> problem_of_size() const {
    if (shop_.limits.points > 0 && found_.added > shop_.limits.points)
      return problem(422,
                     "inputs: hold " + grouped(found_.added) + " points; a job may have at most " +
                         grouped(shop_.limits.points) + " here (limits.points)",
                     Errc::memory);
    const std::uint64_t bytes = bytes_at_least();
    return check_disk("the change needs at least " + human_bytes(bytes) + " of disk; ", bytes, shop_.limits,
                      shop_.data);
  }

 private:
  Status look_at_new_points() {
    BOOST_OUTCOME_TRY(files, shop_.roots.files(list_of(inputs_.inputs()), inputs_.recursive()));
    BOOST_OUTCOME_TRY(packed, any_packed(files));
    if (packed) {
      may_lose_anywhere("compressed files are measured");
      return success();
    }
    BOOST_OUTCOME_TRY(
        cloud, Cloud::open(files, options_of_new_points(manifest_, request_.share.threads), Ledger::token_of_thread()));
    found_.added = expected_points(cloud.files());
    if (found_.added <= new_points_read_max) return place_new_points(cloud, files.front());
    Bounds bounds;
    for (const FileInfo& file : cloud.files()) {
      if (!file.bounds) {
        may_lose_anywhere("the places of so many new points are found");
        return success();
      }
      bounds.add(file.bounds->lo);
      bounds.add(file.bounds->hi);
    }
    may_lose_in(bounds, manifest_.dimension);
    return success();
  }

  Status place_new_points(const Cloud& cloud, const std::string& name) {
    BOOST_OUTCOME_TRY(read, read_new_points(cloud, name, manifest_, source_.folder(), Ledger::token_of_thread()));
    found_.added = read.points.size();
    for (const Point& p : read.points) found_.tiles.losing.insert(partition_.tile_of(without_negative_zero(p)));
    return success();
  }

  Status look_at_ids() {
    BOOST_OUTCOME_TRY(ids, ids_to_remove(shop_, inputs_));
    if (ids.empty()) return success();
    if (manifest_.vertices > vertices_looked_at_max) {
      may_lose_anywhere("the tiles of source indices are found");
      return success();
    }
    PointIds wanted(ids);
    for (std::size_t i = 0; i < source_.tiles() && !wanted.empty(); ++i) {
      BOOST_OUTCOME_TRYV(Ledger::of_thread() == nullptr ? success() : Ledger::of_thread()->go_on());
      BOOST_OUTCOME_TRY(own, source_.read_own_ids(i));
      for (const PointId id : own) {
        if (!wanted.contains(id)) continue;
        wanted.erase(id);
        ++found_.removed_surely[source_.entry(i).tile];
        found_.tiles.losing.insert(source_.entry(i).tile);
      }
    }
    return success();
  }

  void may_lose_in(const Bounds& bounds, int axes) {
    for (const TileEntry& entry : manifest_.tiles) {
      if (meet(query::box_of(manifest_, entry.tile), bounds, axes)) found_.tiles.losing.insert(entry.tile);
    }
  }

  void may_lose_anywhere(const std::string& what) {
    for (const TileEntry& entry : manifest_.tiles) found_.tiles.losing.insert(entry.tile);
    found_.later = "the tiles are at most so many; " + what + " only when the job runs";
  }

  // Of the file that tells tiles which points come and go.
  std::uint64_t plan_bytes() const {
    std::uint64_t removed = 0;
    for (const auto& [tile, points] : found_.removed_surely) removed += points;
    return found_.added * (sizeof(LocalPoint) + row_bytes(without_columns(manifest_).schema)) +
           removed * sizeof(PointId);
  }

  // A tile that loses a vertex gets a new file. New points may all be equal to others.
  std::uint64_t bytes_at_least() const {
    if (inputs_.dry_run()) return plan_bytes();
    double bytes = 0;
    for (const auto& [tile, removed] : found_.removed_surely) {
      const TileEntry& entry = source_.entry(*source_.find(tile));
      const auto own = static_cast<double>(std::max<std::uint64_t>(entry.own_points, 1));
      bytes += static_cast<double>(entry.bytes) * std::max(0.0, own - static_cast<double>(removed)) / own;
    }
    return plan_bytes() + static_cast<std::uint64_t>(bytes);
  }

  const Workshop& shop_;
  const proto::UpdateInputs& inputs_;
  const UpdateRequest& request_;
  TileSource source_;
  const Manifest& manifest_;
  Partition partition_;
  Concerned found_;
};

}  // namespace

Reply<proto::Estimate> estimate_update(const Workshop& shop, const proto::Inputs& all,
                                       std::optional<proto::Problem>& refused) {
  const auto& inputs = all.update();
  const auto request = update_request(inputs, shop.share);
  if (!request) return problem_of(request.error());
  const auto source = TileSource::open(shop.results.folder(inputs.triangulation()));
  if (!source) return problem_of(source.error());
  auto partition = Partition::from_json(source.value().manifest().partition);
  if (!partition) return problem_of(partition.error());
  ChangeCosts costs(shop, inputs, request.value(), source.value(), std::move(partition).value());
  const Status looked = costs.look();
  if (looked) {
    refused = costs.problem_of_size();
    return judged(costs.tell(), refused);
  }
  // The job will find the same, and tell it; it is only too soon to say what it would cost.
  proto::Estimate unknown;
  unknown.set_accepted(true);
  unknown.set_reason(Ledger::reason_of_thread()
                         ? "the change takes too long to measure now; it is measured when the job runs"
                         : in_callers_words(shop, problem_of_inputs(looked.error())).detail());
  return unknown;
}

}  // namespace tessera::service
