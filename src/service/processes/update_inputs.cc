#include "src/service/processes/update_inputs.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "src/base/option.h"
#include "src/input/bytes/byte_source.h"
#include "src/input/bytes/objects.h"
#include "src/input/cloud/cloud.h"
#include "src/input/npy/npy_header.h"
#include "src/job/job_options.h"
#include "src/job/new_points.h"
#include "src/result/tile_source.h"
#include "src/result/voronoi/clip_region.h"
#include "src/result/voronoi/read_clip.h"
#include "src/service/processes/costs.h"
#include "src/service/processes/polygon_text.h"

namespace tessera::service {
namespace {

Error refuse_update(const char* key, const std::string& reason) {
  return error(Errc::usage, option(key) + ": " + reason);
}

Status read_place(const proto::UpdateInputs& inputs, PointSelection& selection) {
  if (inputs.remove_box_size() > 0) {
    const std::vector<double> numbers(inputs.remove_box().begin(), inputs.remove_box().end());
    if (!std::ranges::all_of(numbers, [](double x) { return std::isfinite(x); }))
      return refuse_update("remove-box", "is not a box: one of its numbers is not finite");
    const auto box = crop_box(numbers, 3);
    if (!box) return refuse_update("remove-box", box.error().where);
    selection.box = box.value();
  }
  if (inputs.has_remove_polygon()) {
    BOOST_OUTCOME_TRYV(check_polygons("remove-polygon", inputs.remove_polygon()));
  }
  return success();
}

Status read_attributes(const proto::UpdateInputs& inputs, PointSelection& selection) {
  constexpr int classes_max = 256;
  if (inputs.remove_class_size() > classes_max)
    return refuse_update("remove-class",
                         "has " + std::to_string(inputs.remove_class_size()) + " numbers, and there are 256 classes");
  for (const auto number : inputs.remove_class()) {
    if (number >= classes_max)
      return refuse_update("remove-class",
                           std::to_string(number) + " is not a LAS class, which is a number from 0 to 255");
    selection.classes.push_back(static_cast<int>(number));
  }
  if (inputs.remove_time_size() > 0) {
    if (inputs.remove_time_size() != 2)
      return refuse_update("remove-time", "must be two numbers, the first and the last time");
    const double from = inputs.remove_time(0), to = inputs.remove_time(1);
    if (!std::isfinite(from) || !std::isfinite(to))
      return refuse_update("remove-time", "one of its numbers is not finite");
    if (from > to) return refuse_update("remove-time", "its end is before its begin");
    selection.times = PointSelection::Times{from, to};
  }
  return success();
}

bool removes(const proto::UpdateInputs& inputs) {
  return inputs.remove_ids_size() > 0 || inputs.remove_class_size() > 0 || inputs.remove_box_size() > 0 ||
         inputs.has_remove_polygon() || inputs.has_remove_ids_file() || inputs.remove_time_size() > 0 ||
         inputs.remove_input_size() > 0;
}

// The path in the manifest that a caller means: callers know files below the roots by their names there.
std::string path_in(const Manifest& manifest, const Roots& roots, const std::string& file) {
  for (const auto& input : manifest.inputs) {
    const std::string name = roots.named(input.path);
    // "NAME@FIRST" tells inputs of the same name apart.
    if (file == name) return input.path;
    if (file.starts_with(name + "@")) return input.path + file.substr(name.size());
  }
  return file;
}

Status find_parts(const Workshop& shop, const JobWork& work, const TileSource& source, PointSelection& selection) {
  const auto& inputs = work.job.inputs().update();
  const Manifest& manifest = source.manifest();
  if (selection.box && std::isfinite(selection.box->lo.z) && manifest.dimension == 2 &&
      std::ranges::none_of(manifest.schema, [](const Attribute& a) { return a.name == "z"; }))
    return refuse_update(
        "remove-box", "has heights, and the points of '" + inputs.triangulation() + "' have none; give four numbers");
  if (inputs.has_remove_polygon()) {
    BOOST_OUTCOME_TRY(file, PolygonText::write(work.scratch, "remove-polygon", inputs.remove_polygon(), manifest));
    auto region = voronoi::file_region(file.path(), manifest);
    if (!region) return file.in_callers_words(region.error());
    selection.regions.push_back(std::make_shared<const voronoi::ClipRegion>(std::move(region).value()));
  }
  for (const auto& file : inputs.remove_input()) {
    const auto ids = ids_of_input(source.folder(), manifest, path_in(manifest, shop.roots, file));
    if (!ids) return error(ids.error().code, "remove_input: " + ids.error().where);
    selection.inputs.push_back(ids.value());
  }
  return success();
}

Status add_points(const Workshop& shop, const JobWork& work, const UpdateRequest& request, const TileSource& source,
                  ChangeOfResult& made) {
  const auto& inputs = work.job.inputs().update();
  BOOST_OUTCOME_TRY(files, shop.roots.files(list_of(inputs.inputs()), inputs.recursive()));
  CloudOptions options = options_of_new_points(source.manifest(), request.share.threads);
  options.spool_folder = shop.data;
  options.spool_bytes_max = unpacked_max(shop.limits, shop.data);
  BOOST_OUTCOME_TRY(cloud, Cloud::open(files, options, work.ledger.token()));
  for (const auto& warning : cloud.warnings()) work.log("warning: " + warning);
  const std::string name = files.front() + (files.size() > 1 ? " and others" : "");
  const NewPointsLimits limits{
      .bytes = request.share.memory_bytes / 2,
      .points = shop.limits.points > 0 ? shop.limits.points : std::numeric_limits<std::uint64_t>::max()};
  BOOST_OUTCOME_TRY(read,
                    read_new_points(cloud, name, source.manifest(), source.folder(), work.ledger.token(), limits));
  made.change.add = std::move(read.points);
  made.change.rows = std::move(read.rows);
  made.inputs = std::move(read.inputs);
  return success();
}

}  // namespace

Result<UpdateRequest> update_request(const proto::UpdateInputs& inputs, const JobShare& share) {
  UpdateRequest request;
  BOOST_OUTCOME_TRYV(read_place(inputs, request.selection));
  BOOST_OUTCOME_TRYV(read_attributes(inputs, request.selection));
  if (!removes(inputs) && inputs.inputs_size() == 0)
    return error(Errc::usage,
                 "nothing is to be changed; give inputs with points to add, or remove_ids, remove_ids_file, "
                 "remove_class, remove_box, remove_polygon, remove_time or remove_input");
  if (inputs.replace() && inputs.inputs_size() == 0) return refuse_update("replace", "needs new points; give inputs");
  if (inputs.has_keep_versions()) {
    constexpr std::uint32_t keep_max = 1'000'000;
    if (inputs.keep_versions() < 1 || inputs.keep_versions() > keep_max)
      return refuse_update("keep-versions", "is not a number from 1 to " + std::to_string(keep_max));
    if (!inputs.output().empty() || inputs.dry_run())
      return refuse_update("keep-versions", "is for a change of the result itself, without " + option("output") +
                                                " and " + option("dry-run"));
    request.keep = inputs.keep_versions();
  }
  if (!inputs.output().empty() && inputs.output() == inputs.triangulation())
    return refuse_update("output", "is the result that is changed; without an output it gets a new version");
  if (inputs.overwrite() && inputs.output().empty())
    return refuse_update("overwrite", "is for an output, which is not given");
  BOOST_OUTCOME_TRY(own, share_of_job(inputs, share));
  request.share = own;
  return request;
}

Result<std::vector<PointId>> ids_to_remove(const Workshop& shop, const proto::UpdateInputs& inputs) {
  std::vector<PointId> ids;
  for (const std::uint64_t id : inputs.remove_ids()) ids.push_back(PointId{id});
  if (!inputs.has_remove_ids_file()) return ids;
  const auto read = [&]() -> Result<std::vector<std::uint64_t>> {
    BOOST_OUTCOME_TRY(files, shop.roots.files({inputs.remove_ids_file()}, false));
    if (files.size() != 1)
      return error(Errc::usage, "'" + inputs.remove_ids_file() + "' are " + std::to_string(files.size()) +
                                    " files, and must be one");
    if (names_object(files.front())) return error(Errc::usage, files.front() + ": is an address, and must be a file");
    BOOST_OUTCOME_TRY(file, open_file(files.front()));
    return read_npy_integers(*file);
  };
  const auto listed = read();
  if (!listed) return error(listed.error().code, "remove_ids_file: " + listed.error().where);
  for (const std::uint64_t id : listed.value()) ids.push_back(PointId{id});
  return ids;
}

Result<ChangeOfResult> read_change_of_result(const Workshop& shop, const JobWork& work, UpdateRequest request) {
  const auto& inputs = work.job.inputs().update();
  const auto folder = shop.results.folder(inputs.triangulation());
  BOOST_OUTCOME_TRY(opened, TileSource::open(folder));
  BOOST_OUTCOME_TRYV(check_changeable(folder, opened.manifest()));
  const TileSource source = opened.without_columns().stopped_by(work.ledger.token());
  ChangeOfResult made;
  BOOST_OUTCOME_TRY(ids, ids_to_remove(shop, inputs));
  made.change.remove = std::move(ids);
  BOOST_OUTCOME_TRYV(find_parts(shop, work, source, request.selection));
  if (inputs.inputs_size() > 0) {
    BOOST_OUTCOME_TRYV(add_points(shop, work, request, source, made));
  }
  if (inputs.replace()) request.selection.places = made.change.add;
  BOOST_OUTCOME_TRY(selected, select_points(source, request.selection, request.share.threads, work.ledger.token()));
  made.change.remove.insert(made.change.remove.end(), selected.begin(), selected.end());
  if (!selected.empty()) made.change.chosen_from = source.manifest().version;
  return made;
}

}  // namespace tessera::service
