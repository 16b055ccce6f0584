#include "src/service/processes/drawing_options.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "src/base/files/names.h"
#include "src/base/option.h"
#include "src/job/job_options.h"
#include "src/job/surface_arguments.h"
#include "src/result/export/export.h"
#include "src/result/tileset/tileset.h"
#include "src/service/processes/refuse.h"

namespace tessera::service {
namespace {

// Reads the options that both have.
template <class Inputs, class Options>
Status read_common(const Inputs& inputs, const JobShare& share, Options& options) {
  if (inputs.bbox_size() > 0) {
    const std::vector<double> numbers(inputs.bbox().begin(), inputs.bbox().end());
    for (const double number : numbers)
      if (!std::isfinite(number)) return refuse("bbox", "is not a box: one of its numbers is not finite");
    const auto box = crop_box(numbers, 2);
    if (!box) return refuse("bbox", box.error().where);
    options.box = Bounds{box.value().lo, box.value().hi};
  }
  if (inputs.has_max_edge()) {
    BOOST_OUTCOME_TRY(longest, length_of("max-edge", inputs.max_edge()));
    options.max_edge = longest;
  }
  if (inputs.has_max_radius()) {
    BOOST_OUTCOME_TRY(largest, length_of("max-radius", inputs.max_radius()));
    options.max_radius = largest;
  }
  if (inputs.has_value()) options.value = inputs.value();
  BOOST_OUTCOME_TRY(own, share_of_job(inputs, share));
  options.memory_bytes = own.memory_bytes;
  options.threads = own.threads;
  return success();
}

}  // namespace

Result<DemOptions> dem_options(const proto::DemInputs& inputs, const JobShare& share) {
  DemOptions options;
  BOOST_OUTCOME_TRYV(read_common(inputs, share, options));
  BOOST_OUTCOME_TRY(res, length_of("res", inputs.res()));
  options.res = res;
  if (inputs.has_method()) {
    const auto method = dem_method_of(inputs.method());
    if (!method)
      return refuse("method", "'" + inputs.method() + "' is not a method; the methods are linear, natural and laplace");
    options.method = *method;
  }
  if (inputs.has_type()) {
    if (inputs.type() != "float32" && inputs.type() != "float64")
      return refuse("type", "'" + inputs.type() + "' is not a type of pixels; the types are float32 and float64");
    options.doubles = inputs.type() == "float64";
  }
  Light light;
  if (inputs.has_azimuth()) light.azimuth = inputs.azimuth();
  if (inputs.has_altitude()) light.altitude = inputs.altitude();
  if (inputs.hillshade()) {
    BOOST_OUTCOME_TRYV(check_light(light));
    options.light = light;
  } else if (inputs.has_azimuth() || inputs.has_altitude()) {
    return refuse(inputs.has_azimuth() ? "azimuth" : "altitude",
                  "has an effect only with " + option("hillshade", "true"));
  }
  return options;
}

Result<ContourOptions> contour_options(const proto::ContoursInputs& inputs, const JobShare& share) {
  ContourOptions options;
  BOOST_OUTCOME_TRYV(read_common(inputs, share, options));
  BOOST_OUTCOME_TRY(interval, length_of("interval", inputs.interval()));
  options.interval = interval;
  if (inputs.has_base()) {
    if (!std::isfinite(inputs.base())) return refuse("base", "must be finite");
    options.base = inputs.base();
  }
  if (inputs.has_smooth()) {
    BOOST_OUTCOME_TRY(smooth, length_of("smooth", inputs.smooth()));
    options.smooth = smooth;
  }
  if (inputs.has_min_length()) {
    BOOST_OUTCOME_TRY(shortest, length_of("min-length", inputs.min_length()));
    options.min_length = shortest;
  }
  if (inputs.has_index_every()) {
    if (inputs.index_every() < 1 || inputs.index_every() > index_every_max)
      return refuse("index-every", "must be from 1 to " + std::to_string(index_every_max));
    options.index_every = inputs.index_every();
  }
  return options;
}

namespace {

// Reads an option that is text.
template <class Value>
Status read(const char* key, Result<Value> parsed, Value& to) {
  if (!parsed) return refuse(key, parsed.error().where);
  to = std::move(parsed).value();
  return success();
}

}  // namespace

Result<SurfaceOptions> surface_options(const proto::SurfaceInputs& inputs, const JobShare& share) {
  SurfaceOptions options;
  // A track would be a file of this machine, which the caller must not read.
  if (inputs.has_sensor()) {
    BOOST_OUTCOME_TRYV(read("sensor", parse_sensors(inputs.sensor(), false), options.sensors));
  }
  if (inputs.has_lambda()) options.energy.lambda = inputs.lambda();
  if (inputs.has_alpha()) options.energy.alpha = inputs.alpha();
  if (inputs.has_sigma()) {
    BOOST_OUTCOME_TRY(sigma, length_of("sigma", inputs.sigma()));
    options.energy.sigma = sigma;
  }
  if (inputs.has_ray_length()) {
    BOOST_OUTCOME_TRYV(read("ray-length", parse_ray_length(inputs.ray_length()), options.energy.ray_length));
  }
  if (inputs.has_bottom()) {
    BOOST_OUTCOME_TRYV(read("bottom", parse_bottom(inputs.bottom()), options.bottom));
  }
  if (inputs.has_unknown()) {
    BOOST_OUTCOME_TRYV(read("unknown", parse_unknown(inputs.unknown()), options.unknown_inside));
  }
  if (inputs.has_trim()) {
    BOOST_OUTCOME_TRY(longest, length_of("trim", inputs.trim()));
    options.trim = longest;
  }
  options.manifold = inputs.manifold();
  options.smooth = inputs.smoothing();  // "smooth" means another option of another process
  if (options.smooth > smooth_rounds_max)
    return refuse("smoothing", "is more than " + std::to_string(smooth_rounds_max) + " rounds");
  options.output.format = inputs.format();
  options.output.local = inputs.local();
  BOOST_OUTCOME_TRYV(check_surface_options(options));
  if (options.output.format != tileset_format) {
    const std::string output = inputs.output().empty() ? surface_of_result("").filename().string() : inputs.output();
    BOOST_OUTCOME_TRYV(find_export_target(
        output,
        {.format = options.output.format, .local = options.output.local, .cells_only = true, .overwrite = true}));
  }
  BOOST_OUTCOME_TRY(own, share_of_job(inputs, share));
  options.memory_bytes = own.memory_bytes;
  options.threads = own.threads;
  return options;
}

}  // namespace tessera::service
