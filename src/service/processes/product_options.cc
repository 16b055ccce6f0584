#include "src/service/processes/product_options.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "src/base/option.h"
#include "src/job/arguments.h"
#include "src/job/job_options.h"
#include "src/service/processes/polygon_text.h"
#include "src/service/processes/refuse.h"

namespace tessera::service {
namespace {

template <class Inputs, class Options>
Status read_share(const Inputs& inputs, const JobShare& share, Options& options) {
  BOOST_OUTCOME_TRY(own, share_of_job(inputs, share));
  options.memory_bytes = own.memory_bytes;
  options.threads = own.threads;
  return success();
}

Status read_clip(const std::string& text, VoronoiOptions& options) {
  if (text == "hull" || text == "none") {
    options.clip = text == "hull" ? VoronoiClip::hull : VoronoiClip::none;
    return success();
  }
  if (text.find('{') != std::string::npos) {
    options.clip = VoronoiClip::file;
    BOOST_OUTCOME_TRYV(check_polygons("clip", text));
    return success();
  }
  const auto box = parse_crop(text, 3);
  if (!box) return refuse("clip", "is neither hull, none nor polygons in GeoJSON, and no box: " + box.error().where);
  options.clip = VoronoiClip::box;
  options.box = Bounds{box.value().lo, box.value().hi};
  return success();
}

Status read_names(const proto::DensityInputs& inputs, density::GridOptions& options) {
  const int kinds = (inputs.has_field() ? 1 : 0) + (inputs.divergence_size() > 0 ? 1 : 0) +
                    (inputs.curl_size() > 0 ? 1 : 0) + (inputs.shear_size() > 0 ? 1 : 0);
  if (kinds > 1)
    return error(Errc::usage, option("field") + ", " + option("divergence") + ", " + option("curl") + " and " +
                                  option("shear") + " cannot be on one grid together; give one of them");
  if (inputs.has_field()) {
    options.kind = density::GridKind::field;
    options.names = {inputs.field()};
  } else if (inputs.divergence_size() > 0) {
    options.kind = density::GridKind::divergence;
    options.names = list_of(inputs.divergence());
  } else if (inputs.curl_size() > 0) {
    options.kind = density::GridKind::curl;
    options.names = list_of(inputs.curl());
  } else if (inputs.shear_size() > 0) {
    options.kind = density::GridKind::shear;
    options.names = list_of(inputs.shear());
  }
  return success();
}

}  // namespace

Result<AlphaOptions> alpha_options(const proto::AlphaInputs& inputs, const JobShare& share) {
  AlphaOptions options;
  if (inputs.has_alpha()) {
    BOOST_OUTCOME_TRY(radius, length_of("alpha", inputs.alpha()));
    options.radius = radius;
  }
  options.general = inputs.general();
  BOOST_OUTCOME_TRYV(read_share(inputs, share, options));
  return options;
}

Result<density::GridOptions> density_options(const proto::DensityInputs& inputs, const JobShare& share) {
  density::GridOptions options;
  if (inputs.grid_size() == 0 || inputs.has_res()) {
    BOOST_OUTCOME_TRY(res, length_of("res", inputs.res()));
    options.shape.res = res;
  }
  options.shape.voxels.assign(inputs.grid().begin(), inputs.grid().end());
  if (inputs.bbox_size() > 0) {
    const std::vector<double> numbers(inputs.bbox().begin(), inputs.bbox().end());
    for (const double number : numbers)
      if (!std::isfinite(number)) return refuse("bbox", "is not a box: one of its numbers is not finite");
    const auto box = crop_box(numbers, numbers.size() > 4 ? 3 : 2);
    if (!box) return refuse("bbox", box.error().where);
    options.shape.box = Bounds{box.value().lo, box.value().hi};
  }
  BOOST_OUTCOME_TRYV(read_names(inputs, options));
  options.mass = inputs.mass();
  options.sample = inputs.sample();
  BOOST_OUTCOME_TRYV(read_share(inputs, share, options));
  return options;
}

Result<VolumeOptions> volume_options(const proto::VolumeInputs& inputs, const JobShare& share) {
  VolumeOptions options;
  if (inputs.has_plane()) options.plane = inputs.plane();
  if (inputs.has_base()) options.base = "base";
  if (inputs.has_within()) options.within = "within";
  options.name = inputs.name();
  BOOST_OUTCOME_TRYV(check_volume_options(!inputs.second().empty(), options));
  if (inputs.has_base()) {
    BOOST_OUTCOME_TRYV(check_polygons("base", inputs.base()));
  }
  if (inputs.has_within()) {
    BOOST_OUTCOME_TRYV(check_polygons("within", inputs.within()));
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
  BOOST_OUTCOME_TRYV(read_share(inputs, share, options));
  return options;
}

Result<VoronoiOptions> voronoi_options(const proto::VoronoiInputs& inputs, const JobShare& share) {
  VoronoiOptions options;
  if (inputs.has_clip()) {
    BOOST_OUTCOME_TRYV(read_clip(inputs.clip(), options));
  }
  BOOST_OUTCOME_TRYV(read_share(inputs, share, options));
  return options;
}

}  // namespace tessera::service
