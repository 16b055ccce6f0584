#include "tessera/raster.h"

#include <utility>

#include "src/front/api/errors.h"
#include "src/front/api/options_inside.h"
#include "src/front/api/surface_request_inside.h"
#include "src/result/terrain/dem.h"

namespace tessera {

template <>
struct AskedOfEngine<RasterRequest> {
  using Options = DemOptions;
};
template class SurfaceRequest<RasterRequest>;

RasterRequest::RasterRequest(double res) { impl_->options.res = res; }
RasterRequest& RasterRequest::bbox(const std::array<double, 4>& box) {
  impl_->options.box = Bounds{{box[0], box[1], 0}, {box[2], box[3], 0}};
  return *this;
}
RasterRequest& RasterRequest::method(RasterMethod method) {
  switch (method) {
    case RasterMethod::linear:
      impl_->options.method = DemMethod::linear;
      break;
    case RasterMethod::natural:
      impl_->options.method = DemMethod::natural;
      break;
    case RasterMethod::laplace:
      impl_->options.method = DemMethod::laplace;
      break;
  }
  return *this;
}
RasterRequest& RasterRequest::hillshade(double azimuth, double altitude) {
  impl_->options.light = Light{azimuth, altitude};
  return *this;
}
RasterRequest& RasterRequest::doubles(bool doubles) {
  impl_->options.doubles = doubles;
  return *this;
}
RasterRequest& RasterRequest::threads(unsigned threads) {
  impl_->options.threads = threads;
  return *this;
}

Raster draw_raster(const Triangulation& triangulation, const RasterRequest& request) {
  return guarded([&] {
    const auto& asked = OptionsInside::of(request);
    const DemOptions options = asked.chosen();
    auto drawn = value_or_throw(
        draw_dem(triangulation.folder(), options, options.memory_bytes / 2 / sizeof(double), asked.stop));
    return Raster{drawn.width,    drawn.height,           drawn.left, drawn.top, drawn.pixels,
                  drawn.left_out, std::move(drawn.values)};
  });
}

std::string write_raster(const Triangulation& triangulation, const std::filesystem::path& target,
                         const RasterRequest& request) {
  return guarded([&] {
    const auto& asked = OptionsInside::of(request);
    return value_or_throw(write_dem(triangulation.folder(), target, asked.chosen(), asked.stop)).note;
  });
}

}  // namespace tessera
