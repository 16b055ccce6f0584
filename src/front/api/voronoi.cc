#include "tessera/voronoi.h"

#include <limits>
#include <utility>

#include "src/base/option.h"
#include "src/front/api/errors.h"
#include "src/front/api/options_inside.h"
#include "src/job/machine.h"
#include "src/result/voronoi/voronoi.h"

namespace tessera {

struct VoronoiRequest::Impl {
  VoronoiOptions options = {};  // 0 threads and 0 bytes let the library choose
  std::stop_token stop;

  VoronoiOptions chosen() const {
    VoronoiOptions all = options;
    if (all.memory_bytes == 0) all.memory_bytes = default_memory();
    if (all.threads == 0) all.threads = usable_processors();
    return all;
  }
};

VoronoiRequest::VoronoiRequest() : impl_(std::make_unique<Impl>()) {}
VoronoiRequest::VoronoiRequest(const VoronoiRequest& other) : impl_(std::make_unique<Impl>(*other.impl_)) {}
VoronoiRequest& VoronoiRequest::operator=(const VoronoiRequest& other) {
  *impl_ = *other.impl_;
  return *this;
}
VoronoiRequest::~VoronoiRequest() = default;

VoronoiRequest& VoronoiRequest::clip_to_hull() {
  impl_->options.clip = VoronoiClip::hull;
  return *this;
}
VoronoiRequest& VoronoiRequest::clip_to_nothing() {
  impl_->options.clip = VoronoiClip::none;
  return *this;
}
VoronoiRequest& VoronoiRequest::clip_to_box(std::span<const double> box) {
  guarded([&] {
    if (box.size() != 4 && box.size() != 6)
      or_throw(error(Errc::usage, option("clip") + ": is a box of 4 numbers in 2D, or 6 in 3D"));
  });
  const std::size_t d = box.size() / 2;
  constexpr double far = std::numeric_limits<double>::infinity();
  impl_->options.clip = VoronoiClip::box;
  impl_->options.box = Bounds{{box[0], box[1], d == 3 ? box[2] : -far}, {box[d], box[d + 1], d == 3 ? box[5] : far}};
  return *this;
}
VoronoiRequest& VoronoiRequest::clip_to_file(const std::filesystem::path& polygons) {
  impl_->options.clip = VoronoiClip::file;
  impl_->options.polygons = polygons;
  return *this;
}
VoronoiRequest& VoronoiRequest::overwrite(bool overwrite) {
  impl_->options.overwrite = overwrite;
  return *this;
}
VoronoiRequest& VoronoiRequest::memory_bytes(std::uint64_t bytes) {
  impl_->options.memory_bytes = bytes;
  return *this;
}
VoronoiRequest& VoronoiRequest::threads(unsigned threads) {
  impl_->options.threads = threads;
  return *this;
}
VoronoiRequest& VoronoiRequest::stop(std::stop_token stop) {
  impl_->stop = std::move(stop);
  return *this;
}

VoronoiFile write_voronoi(const Triangulation& triangulation, const std::filesystem::path& target,
                          const VoronoiRequest& request) {
  return guarded([&] {
    const auto& asked = OptionsInside::of(request);
    auto written = value_or_throw(write_voronoi(triangulation.folder(), target, asked.chosen(), asked.stop));
    return VoronoiFile{.cells = written.cells,
                       .unbounded = written.unbounded,
                       .outside = written.outside,
                       .size = written.size,
                       .note = std::move(written.note)};
  });
}

}  // namespace tessera
