// Routes a cloud of any size to the files of a run folder, in bounded memory.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>

#include "src/base/files/folder.h"
#include "src/base/files/names.h"
#include "src/base/files/whole_file.h"
#include "src/base/option.h"
#include "src/input/cloud/cloud_sample.h"
#include "src/input/cloud/input_splits.h"
#include "src/input/cloud/point_filter.h"
#include "src/input/cloud/settle_period.h"
#include "src/tiling/budget/budget.h"
#include "src/tiling/kept_points.h"
#include "src/tiling/plan.h"
#include "src/tiling/refine.h"
#include "src/tiling/routed_cloud.h"
#include "src/tiling/tile_writer.h"

namespace tessera {
namespace {

// Makes the folders, and removes what an unfinished run has left in them. Unless keep() is called, the destructor
// removes what was made.
class RunFolder {
 public:
  explicit RunFolder(const std::filesystem::path& path)
      : path_(path), parts_{plan_file(path),           temporary_name(plan_file(path)), segments_file(path),
                            points_folder(path),       attributes_folder(path),         routing_file(path),
                            routed_splits_folder(path)} {}
  RunFolder(const RunFolder&) = delete;
  RunFolder& operator=(const RunFolder&) = delete;
  ~RunFolder() {
    if (keep_) return;
    // The job is failing already. The next run removes what cannot be removed now, and the first error is the one to
    // report.
    for (const auto& path : parts_) remove_tree(path);
  }

  Status prepare(bool with_rows) {
    for (const auto& path : parts_) {
      BOOST_OUTCOME_TRYV(remove_whole(path));
    }
    BOOST_OUTCOME_TRYV(make_directories(points_folder(path_)));
    if (with_rows) return make_directories(attributes_folder(path_));
    return success();
  }
  void keep() { keep_ = true; }

 private:
  std::filesystem::path path_;
  std::array<std::filesystem::path, 7> parts_;
  bool keep_ = false;
};

struct Survey {
  std::vector<Point> sample;
  std::uint64_t total = 0;  // 0 if unknown
};

// Reads the whole cloud once. That is needed where no header tells the number of points, or where a filter drops an
// unknown part. Keeps every k-th point for the sample; k doubles whenever there are twice as many as wanted.
Result<Survey> survey_all(const Cloud& cloud, std::size_t wanted, const std::stop_token& stop) {
  Survey survey;
  std::uint64_t stride = 1;
  const auto visit = [&](CloudBatch& batch) -> Status {
    if (stop.stop_requested()) return error(Errc::interrupted, "interrupted while points were counted");
    for (const LocalPoint& p : batch.points) {
      if (survey.total++ % stride != 0) continue;
      survey.sample.push_back(p.at);
      if (survey.sample.size() < 2 * wanted) continue;
      for (std::size_t i = 0; i < wanted; ++i) survey.sample[i] = survey.sample[2 * i];
      survey.sample.resize(wanted);
      stride *= 2;
    }
    return success();
  };
  BOOST_OUTCOME_TRYV(cloud.for_each_batch(visit));
  return survey;
}

Result<Survey> survey_cloud(const Cloud& cloud, const RouteOptions& options, const std::stop_token& stop) {
  Survey survey;
  bool known = !cloud.options().crop && filtered_by(cloud.options()).empty();
  for (const FileInfo& file : cloud.files()) {
    known = known && file.points.has_value();
    survey.total += file.points.value_or(0);
  }
  const auto wanted = static_cast<std::size_t>(budget::sample_points(options.memory_bytes, survey.total));
  if (!known && options.tiles == 0) return survey_all(cloud, wanted, stop);
  if (!known) survey.total = 0;
  BOOST_OUTCOME_TRY(sample, sample_cloud(cloud, wanted));
  survey.sample = std::move(sample);
  return survey;
}

Partition choose_partition(const Survey& survey, int dimension, const RouteOptions& options) {
  Bounds bounds;
  for (const Point& p : survey.sample) bounds.add(p);
  if (options.tiles > 0) {
    return Partition::build_tiles(options.kind, dimension, survey.sample, bounds, options.tiles);
  }
  const std::uint64_t limit = options.max_points_per_tile > 0 ? options.max_points_per_tile : UINT64_MAX;
  return Partition::build(options.kind, dimension, survey.sample, bounds, survey.total, limit);
}

std::string name_of(const Cloud& cloud) {
  if (cloud.files().size() == 1) return cloud.files()[0].path.string();
  return "the " + std::to_string(cloud.files().size()) + " input files";
}

// Returns which classes and bounds were filtered out, for a user whose filter has left no points.
std::string what_there_is(const CloudCounts& counts) {
  std::string text;
  for (std::size_t c = 0; c < counts.other_classes.size(); ++c)
    if (counts.other_classes[c]) text += (text.empty() ? "; there are the classes " : ", ") + std::to_string(c);
  if (!counts.outside.empty()) {
    const auto& [lo, hi] = counts.outside;
    const auto side = [](const char* name, double a, double b) {
      std::array<char, 80> text{};
      std::snprintf(text.data(), text.size(), "%s from %.10g to %.10g", name, a, b);
      return std::string(text.data());
    };
    text += "; points lie at " + side("x", lo.x, hi.x) + ", " + side("y", lo.y, hi.y) + ", " + side("z", lo.z, hi.z);
  }
  return text;
}

// Refuses a cloud that has no triangulation.
Status check_span(const Cloud& cloud, int dimension, const CloudCounts& counts, int rank) {
  const Period& period = cloud.options().period;
  const std::uint64_t points = counts.read - counts.invalid - counts.filtered;
  const auto refuse = [&](const std::string& reason) { return error(Errc::bad_input, name_of(cloud) + ": " + reason); };
  if (points == 0 && counts.read > 0) {
    return refuse("no points are left of " + std::to_string(counts.read) + ": " + std::to_string(counts.filtered) +
                  " were filtered out, " + std::to_string(counts.invalid) + " were not finite" + what_there_is(counts) +
                  (cloud.options().scans.empty() ? "" : "; scans are numbered from 0"));
  }
  if (const auto reason = why_too_large(counts, period); !reason.empty()) return refuse(reason);
  if (rank == period.open_axes(dimension)) return success();
  const bool plane = rank == 2 && points > 3;
  return refuse(why_flat(points, rank, dimension, period) + (plane ? " (try " + option("dim", "2") + ")" : ""));
}

// Moves into the plan what is known of the points, once all records are where they stay.
void settle(RoutedCloud& run, RoutedPoints& routed) {
  run.bundles = std::move(routed.bundles);
  for (std::uint32_t t = 0; t < run.partition.tiles(); ++t) {
    run.tile_points.push_back(routed.points_of(TileId{t}));
    run.segments.insert(run.segments.end(), routed.segments[t].begin(), routed.segments[t].end());
    run.segment_end.push_back(run.segments.size());
  }
  run.tile_bounds = std::move(routed.bounds);
  run.checked = std::make_shared<std::vector<TileChecked>>(run.tile_points.size());
  for (const Bounds& bounds : run.tile_bounds) run.bounds.add(bounds);
  std::vector<LocalPoint> everywhere = routed.span.span();
  if (!run.partition.period().any()) everywhere.push_back(routed.span.least());  // the proof for periods needs none
  run.seeds = routed.seeds.choose(run.partition, run.tile_bounds, everywhere);
}

}  // namespace

Result<RoutedCloud> route(const Cloud& cloud, const std::filesystem::path& folder, const RouteOptions& options,
                          Progress& progress, std::stop_token stop, SplitRouter* router) {
  if (options.tiles > Partition::tiles_max) {
    return error(Errc::usage, std::to_string(options.tiles) + " tiles are more than the " +
                                  std::to_string(Partition::tiles_max) + " that can be made");
  }
  RoutedCloud run;
  run.folder = folder;
  run.dimension = cloud.options().dimension;
  run.keep = cloud.options().keep;
  run.schema = cloud.schema();
  run.crs = cloud.crs();
  run.unit = cloud.unit();
  run.options_key = options.options_key;
  for (const FileInfo& file : cloud.files()) run.inputs.push_back({file.path.string(), file.bytes, file.modified_ns});
  const std::size_t row = row_bytes(run.schema);

  RunFolder files(folder);
  BOOST_OUTCOME_TRYV(files.prepare(row > 0));
  std::uint64_t points_max = 0;  // a file cannot hold more points than bytes, whatever its header says
  for (const FileInfo& file : cloud.files())
    points_max += std::min(file.points.value_or(file.content_bytes), file.content_bytes);
  {
    BOOST_OUTCOME_TRY(survey, survey_cloud(cloud, options, stop));
    progress.points_total = survey.total;
    run.partition = choose_partition(survey, run.dimension, options);
    run.partition.set_period(cloud.options().period);
  }
  progress.tiles_total = run.partition.tiles();

  const std::uint64_t buffer =
      std::min(budget::route_buffer_bytes(options.memory_bytes), (points_max + 1) * TileWriter::bytes_per_point(row));
  TileWriter writer(folder, 0, run.dimension, row, buffer, run.partition.period());
  RoutedPoints& routed = writer.routed();
  std::vector<InputSplit> splits{cloud.whole()};
  if (router) {
    BOOST_OUTCOME_TRY(cut, cut_into_splits(cloud, router->split_points(progress.points_total)));
    splits = std::move(cut);
  }
  if (splits.size() > 1) {
    BOOST_OUTCOME_TRYV(make_directories(routed_splits_folder(folder)));
    BOOST_OUTCOME_TRY(attempts, router->route(cloud, splits, run.partition, folder, progress, stop));
    for (const std::uint32_t attempt : attempts) {
      BOOST_OUTCOME_TRY(next, read_split(folder, attempt, run.partition));
      routed.append(next);
    }
    BOOST_OUTCOME_TRYV(remove_whole(routed_splits_folder(folder)));
  } else {
    BOOST_OUTCOME_TRYV(write_split(cloud, splits.front(), run.partition, writer, stop,
                                   [&](std::uint64_t points) { progress.points_routed += points; }));
  }
  run.counts = routed.counts;
  for (std::size_t i = 0; i < std::min(run.inputs.size(), routed.of_files.size()); ++i)
    run.inputs[i].points = routed.of_files[i];
  BOOST_OUTCOME_TRYV(check_span(cloud, run.dimension, run.counts, routed.span.rank()));
  if (options.tiles == 0 && options.max_points_per_tile > 0) {
    BOOST_OUTCOME_TRYV(split_large_tiles(run.partition, writer, folder, row, options.max_points_per_tile,
                                         budget::refine_bytes(options.memory_bytes), stop));
  }
  settle(run, routed);
  BOOST_OUTCOME_TRYV(choose_kept_seeds(run, stop));
  progress.points_total = progress.points_routed.load();
  progress.tiles_total = run.partition.tiles();
  BOOST_OUTCOME_TRY(seal, write_plan(run));
  run.seal = seal;
  files.keep();
  return run;
}

}  // namespace tessera
