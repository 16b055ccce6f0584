#include "tessera/update.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "src/delaunay/update/select_points.h"
#include "src/delaunay/update/update.h"
#include "src/front/api/errors.h"
#include "src/front/api/options_inside.h"
#include "src/front/api/triangulation_impl.h"
#include "src/input/cloud/cloud.h"
#include "src/input/npy/array_source.h"
#include "src/job/engine_steps.h"
#include "src/job/machine.h"
#include "src/job/new_points.h"
#include "src/job/version.h"
#include "src/result/tile_source.h"

namespace tessera {

struct UpdateRequest::Impl {
  std::optional<std::span<const double>> coordinates;
  std::optional<Records> records;
  std::vector<PointId> remove;
  bool replace = false;
  UpdateOptions options = {.threads = 0};  // 0 threads let the library choose
  std::stop_token stop;
};

UpdateRequest::UpdateRequest() : impl_(std::make_unique<Impl>()) {}
UpdateRequest::UpdateRequest(const UpdateRequest& other) : impl_(std::make_unique<Impl>(*other.impl_)) {}
UpdateRequest& UpdateRequest::operator=(const UpdateRequest& other) {
  *impl_ = *other.impl_;
  return *this;
}
UpdateRequest::~UpdateRequest() = default;

UpdateRequest& UpdateRequest::add(std::span<const double> coordinates) {
  impl_->coordinates = coordinates;
  impl_->records.reset();
  return *this;
}
UpdateRequest& UpdateRequest::add(const Records& records) {
  impl_->records = records;
  impl_->coordinates.reset();
  return *this;
}
UpdateRequest& UpdateRequest::remove(std::span<const std::uint64_t> ids) {
  impl_->remove.clear();
  for (const std::uint64_t id : ids) impl_->remove.push_back(PointId{id});
  return *this;
}
UpdateRequest& UpdateRequest::replace(bool replace) {
  impl_->replace = replace;
  return *this;
}
UpdateRequest& UpdateRequest::output(const std::filesystem::path& folder) {
  impl_->options.to = folder;
  return *this;
}
UpdateRequest& UpdateRequest::threads(unsigned threads) {
  impl_->options.threads = threads;
  return *this;
}
UpdateRequest& UpdateRequest::stop(std::stop_token stop) {
  impl_->stop = std::move(stop);
  return *this;
}

namespace {

// A cloud of the new points; nothing when there are none.
std::optional<Cloud> cloud_of(const std::optional<std::span<const double>>& coordinates,
                              const std::optional<Records>& records, const Manifest& manifest, unsigned threads) {
  const auto dimension = static_cast<std::size_t>(manifest.dimension);
  const CloudOptions options = options_of_new_points(manifest, threads);
  if (coordinates && coordinates->size() % dimension != 0)
    throw Failure(Cause::usage, "the array: its length, " + std::to_string(coordinates->size()) +
                                    ", is not a multiple of the dimension, " + std::to_string(dimension));
  if (coordinates && !coordinates->empty())
    return value_or_throw(Cloud::open_source(array_source("the array", *coordinates, manifest.dimension), options));
  if (records && records->rows > 0)
    return value_or_throw(
        Cloud::open_source(record_source("the array", records->bytes, records->columns, records->rows), options));
  return std::nullopt;
}

}  // namespace

UpdateReport update(const Triangulation& triangulation, const UpdateRequest& request) {
  return guarded([&] {
    const auto& asked = OptionsInside::of(request);
    const std::filesystem::path folder = triangulation.folder();
    const TileSource opened = value_or_throw(TileSource::open(folder));
    or_throw(check_changeable(folder, opened.manifest()));
    const TileSource source = opened.without_columns().stopped_by(asked.stop);
    UpdateOptions options = asked.options;
    if (options.threads == 0) options.threads = usable_processors();
    options.software_version = version();
    ResultChange change{.remove = asked.remove};
    if (const auto cloud = cloud_of(asked.coordinates, asked.records, source.manifest(), options.threads)) {
      auto read = value_or_throw(read_new_points(*cloud, "the array", source.manifest(), folder, asked.stop));
      change.add = std::move(read.points);
      change.rows = std::move(read.rows);
      options.inputs = std::move(read.inputs);
    }
    if (asked.replace) {
      const auto replaced = value_or_throw(select_points(source, {.places = change.add}, options.threads, asked.stop));
      change.remove.insert(change.remove.end(), replaced.begin(), replaced.end());
    }
    const std::uint64_t memory = default_memory();
    Engine engine(options.threads, memory, kinds_of_stages());
    Progress progress;
    EngineStages stages(engine, {.threads = options.threads, .memory_bytes = memory, .resumable = false}, progress);
    const auto updated = value_or_throw(update_result(folder, change, options, stages, asked.stop));
    return UpdateReport{.first_id = updated.first_new,
                        .removed = updated.removed,
                        .added = change.add.size(),
                        .equal = updated.duplicates,
                        .tiles = updated.tiles,
                        .tiles_awake = updated.awake,
                        .tiles_changed = updated.written};
  });
}

}  // namespace tessera
