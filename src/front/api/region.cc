#include "tessera/region.h"

#include <cmath>
#include <optional>
#include <utility>

#include "src/base/option.h"
#include "src/front/api/errors.h"
#include "src/front/api/far_objects.h"
#include "src/front/api/options_inside.h"
#include "src/front/api/triangulation_maker.h"
#include "src/input/bytes/objects.h"
#include "src/job/region_job.h"
#include "src/tiling/budget/budget.h"

namespace tessera {

struct RegionRequest::Impl {
  bool scan_files = false;
  RegionLimits limits;
};

RegionRequest::RegionRequest() : impl_(std::make_unique<Impl>()) {}
RegionRequest::RegionRequest(const RegionRequest& other) : impl_(std::make_unique<Impl>(*other.impl_)) {}
RegionRequest& RegionRequest::operator=(const RegionRequest& other) {
  *impl_ = *other.impl_;
  return *this;
}
RegionRequest::~RegionRequest() = default;

RegionRequest& RegionRequest::scan_files(bool scan) {
  impl_->scan_files = scan;
  return *this;
}
RegionRequest& RegionRequest::max_points(std::uint64_t points) {
  impl_->limits.max_points = points;
  return *this;
}
RegionRequest& RegionRequest::max_seconds(double seconds) {
  impl_->limits.max_seconds = seconds;
  return *this;
}

namespace {

RegionJobOptions region_options(std::span<const double> box, const TriangulationOptions& given,
                                const RegionRequest& request) {
  const auto& asked = OptionsInside::of(request);
  const JobOptions job = job_options(given);
  RegionJobOptions options{.cloud = job.cloud,
                           .scan_files = asked.scan_files,
                           .box = {},
                           .limits = asked.limits,
                           .neighbors = job.neighbors,
                           .command = {"tessera::triangulate_region"}};
  options.cloud.threads = budget::reading_threads(job.memory_bytes, job.threads);
  options.limits.memory_bytes = job.memory_bytes;
  for (const double bound : box)
    if (!std::isfinite(bound)) throw_failure(error(Errc::usage, option("bbox") + ": must be finite"));
  const auto area = crop_box(box, options.cloud.dimension == 2 ? 2 : 3);
  if (!area) throw_failure(error(area.error().code, option("bbox") + ": " + area.error().where));
  options.box = area.value();
  if (!(asked.limits.max_seconds > 0)) throw_failure(error(Errc::usage, option("max-seconds") + ": must be above 0"));
  return options;
}

}  // namespace

Triangulation triangulate_region(const std::vector<std::string>& inputs, std::span<const double> box,
                                 const TriangulationOptions& options, const RegionRequest& request) {
  const auto& asked = OptionsInside::of(options);
  std::vector<std::string> warnings;
  auto made = guarded([&] {
    if (inputs.empty() && asked.job.cloud.input_list.empty())
      throw_failure(error(Errc::usage, "no input file is given"));
    if (asked.resume)
      throw_failure(
          error(Errc::usage, option("resume") + ": a region cannot be resumed, because it is always made anew"));
    const RegionJobOptions job = region_options(box, options, request);
    std::optional<TemporaryFolder> temporary;
    if (asked.folder.empty()) temporary.emplace(value_or_throw(TemporaryFolder::make()));
    const auto path = temporary ? temporary->path() : asked.folder;
    auto folder = value_or_throw(ResultFolder::inspect(path, false, asked.overwrite));  // fails before input is read
    const UseObjects use(far_objects(asked.s3));
    auto cloud = value_or_throw(open_regions(inputs, job, asked.stop));
    auto summary = write_region(cloud, job, folder, asked.stop);
    if (!summary) {
      folder.abandon();
      throw_failure(summary.error());
    }
    warnings = std::move(summary.value().warnings);
    return TriangulationMaker::open(path, std::move(temporary));
  });
  const Entry entry;
  for (const auto& warning : warnings) call_back(asked.warning, warning);
  return made;
}

}  // namespace tessera
