#include "src/service/drawing_options.h"

#include <cmath>
#include <vector>

#include "src/base/option.h"
#include "src/job/job_options.h"

namespace tessera {
namespace {

Error refuse(const char* key, const std::string& reason) { return error(Errc::usage, option(key) + ": " + reason); }

// What both have, into either's options.
template <class Inputs, class Options>
Status read_common(const Inputs& inputs, const Share& share, Options& options) {
  if (inputs.bbox_size() > 0) {
    const std::vector<double> numbers(inputs.bbox().begin(), inputs.bbox().end());
    for (const double number : numbers)
      if (!std::isfinite(number)) return refuse("bbox", "is not a box: a number of it is not finite");
    const auto box = crop_box(numbers, 2);
    if (!box) return refuse("bbox", box.error().where);
    options.box = Bounds{box.value().lo, box.value().hi};
  }
  if (inputs.has_max_edge()) {
    BOOST_OUTCOME_TRY(longest, length_of("max-edge", inputs.max_edge()));
    options.max_edge = longest;
  }
  if (inputs.has_value()) options.value = inputs.value();
  BOOST_OUTCOME_TRY(own, share_of_job(inputs, share));
  options.memory_bytes = own.memory_bytes;
  options.threads = own.threads;
  return success();
}

}  // namespace

Result<DemOptions> dem_options(const proto::DemInputs& inputs, const Share& share) {
  DemOptions options;
  BOOST_OUTCOME_TRYV(read_common(inputs, share, options));
  BOOST_OUTCOME_TRY(res, length_of("res", inputs.res()));
  options.res = res;
  if (inputs.has_type()) {
    if (inputs.type() != "float32" && inputs.type() != "float64")
      return refuse("type", "'" + inputs.type() + "' is no type of pixels; there are float32 and float64");
    options.doubles = inputs.type() == "float64";
  }
  Light light;
  if (inputs.has_azimuth()) light.azimuth = inputs.azimuth();
  if (inputs.has_altitude()) light.altitude = inputs.altitude();
  if (inputs.hillshade()) {
    BOOST_OUTCOME_TRYV(check_light(light));
    options.light = light;
  } else if (inputs.has_azimuth() || inputs.has_altitude()) {
    return refuse(inputs.has_azimuth() ? "azimuth" : "altitude", "belongs to " + option("hillshade", "true"));
  }
  return options;
}

Result<ContourOptions> contour_options(const proto::ContoursInputs& inputs, const Share& share) {
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

}  // namespace tessera
