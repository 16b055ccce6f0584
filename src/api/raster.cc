#include "tessera/raster.h"

#include <utility>

#include "src/api/errors.h"
#include "src/api/options_inside.h"
#include "src/base/option.h"
#include "src/job/machine.h"
#include "src/terrain/dem.h"

namespace tessera {

struct RasterRequest::Impl {
  DemOptions options;
  std::stop_token stop;
};

RasterRequest::RasterRequest(double res) : impl_(std::make_unique<Impl>()) {
  impl_->options = {.res = res, .memory_bytes = 0, .threads = 0};
}
RasterRequest::RasterRequest(const RasterRequest& other) : impl_(std::make_unique<Impl>(*other.impl_)) {}
RasterRequest& RasterRequest::operator=(const RasterRequest& other) {
  *impl_ = *other.impl_;
  return *this;
}
RasterRequest::~RasterRequest() = default;

RasterRequest& RasterRequest::bbox(const std::array<double, 4>& box) {
  impl_->options.box = Bounds{{box[0], box[1], 0}, {box[2], box[3], 0}};
  return *this;
}
RasterRequest& RasterRequest::max_edge(double length) {
  impl_->options.max_edge = length;
  return *this;
}
RasterRequest& RasterRequest::value(const std::string& name) {
  impl_->options.value = name;
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
RasterRequest& RasterRequest::overwrite(bool overwrite) {
  impl_->options.overwrite = overwrite;
  return *this;
}
RasterRequest& RasterRequest::memory_bytes(std::uint64_t bytes) {
  impl_->options.memory_bytes = bytes;
  return *this;
}
RasterRequest& RasterRequest::threads(unsigned threads) {
  impl_->options.threads = threads;
  return *this;
}
RasterRequest& RasterRequest::stop(std::stop_token stop) {
  impl_->stop = std::move(stop);
  return *this;
}

namespace {

DemOptions chosen(DemOptions options) {
  if (options.memory_bytes == 0) options.memory_bytes = default_memory();
  if (options.threads == 0) options.threads = usable_processors();
  return options;
}

}  // namespace

Raster draw_raster(const Triangulation& triangulation, const RasterRequest& request) {
  return guarded([&] {
    const auto& asked = OptionsInside::of(request);
    const DemOptions options = chosen(asked.options);
    if (options.light)
      throw_failure(error(Errc::usage, option("hillshade", "true") + ": is written to a file; give its name"));
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
    return value_or_throw(write_dem(triangulation.folder(), target, chosen(asked.options), asked.stop)).note;
  });
}

}  // namespace tessera
