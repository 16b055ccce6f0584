#include "tessera/alpha.h"

#include <utility>

#include "src/front/api/errors.h"
#include "src/front/api/options_inside.h"
#include "src/job/machine.h"
#include "src/result/alpha/alpha_shape.h"

namespace tessera {

struct AlphaRequest::Impl {
  AlphaOptions options{.memory_bytes = 0, .threads = 0};  // 0 threads and 0 bytes let the library choose
  std::stop_token stop;
};

AlphaRequest::AlphaRequest() : impl_(std::make_unique<Impl>()) {}
AlphaRequest::AlphaRequest(const AlphaRequest& other) : impl_(std::make_unique<Impl>(*other.impl_)) {}
AlphaRequest& AlphaRequest::operator=(const AlphaRequest& other) {
  *impl_ = *other.impl_;
  return *this;
}
AlphaRequest::~AlphaRequest() = default;

AlphaRequest& AlphaRequest::alpha(double radius) {
  impl_->options.radius = radius;
  return *this;
}
AlphaRequest& AlphaRequest::general(bool general) {
  impl_->options.general = general;
  return *this;
}
AlphaRequest& AlphaRequest::overwrite(bool overwrite) {
  impl_->options.overwrite = overwrite;
  return *this;
}
AlphaRequest& AlphaRequest::memory_bytes(std::uint64_t bytes) {
  impl_->options.memory_bytes = bytes;
  return *this;
}
AlphaRequest& AlphaRequest::threads(unsigned threads) {
  impl_->options.threads = threads;
  return *this;
}
AlphaRequest& AlphaRequest::stop(std::stop_token stop) {
  impl_->stop = std::move(stop);
  return *this;
}

namespace {

AlphaOptions chosen(AlphaOptions options) {
  if (options.memory_bytes == 0) options.memory_bytes = default_memory();
  if (options.threads == 0) options.threads = usable_processors();
  return options;
}

}  // namespace

AlphaSurface make_alpha_shape(const Triangulation& triangulation, const AlphaRequest& request) {
  return guarded([&] {
    const auto& asked = OptionsInside::of(request);
    AlphaArrays made = value_or_throw(make_alpha_shape(triangulation.folder(), chosen(asked.options), asked.stop));
    return AlphaSurface{.radius = made.radius,
                        .cells = made.cells,
                        .ids = std::move(made.ids),
                        .points = std::move(made.points),
                        .facets = std::move(made.facets),
                        .singular_facets = std::move(made.singular_facets),
                        .singular_edges = std::move(made.singular_edges),
                        .singular_vertices = std::move(made.singular_vertices)};
  });
}

double write_alpha_shape(const Triangulation& triangulation, const std::filesystem::path& target,
                         const AlphaRequest& request) {
  return guarded([&] {
    const auto& asked = OptionsInside::of(request);
    return value_or_throw(write_alpha_shape(triangulation.folder(), target, chosen(asked.options), asked.stop)).radius;
  });
}

}  // namespace tessera
