// The inside of SurfaceRequest, and its functions. One file of the library instantiates them for each request.
#pragma once

#include <memory>
#include <stop_token>
#include <string>
#include <utility>

#include "src/job/machine.h"
#include "tessera/surface_request.h"

namespace tessera {

// Each request specialises this with a type `Options`: the options of the engine for this request.
template <class Request>
struct AskedOfEngine;

template <class Request>
struct SurfaceRequest<Request>::Impl {
  // As the program set them; 0 threads and 0 bytes let the library choose.
  typename AskedOfEngine<Request>::Options options = {};
  bool overwrite = false;
  std::stop_token stop;

  // Returns the options of the engine, with all choices of the library made.
  auto chosen() const {
    auto all = options;
    if (all.memory_bytes == 0) all.memory_bytes = default_memory();
    if constexpr (requires { all.threads; }) {
      if (all.threads == 0) all.threads = usable_processors();
    }
    if constexpr (requires { all.overwrite; }) all.overwrite = overwrite;
    if constexpr (requires { all.stop; }) all.stop = stop;
    return all;
  }
};

template <class Request>
SurfaceRequest<Request>::SurfaceRequest() : impl_(std::make_unique<Impl>()) {
  impl_->options.memory_bytes = 0;
  if constexpr (requires { impl_->options.threads; }) impl_->options.threads = 0;
}
template <class Request>
SurfaceRequest<Request>::SurfaceRequest(const SurfaceRequest& other) : impl_(std::make_unique<Impl>(*other.impl_)) {}
template <class Request>
SurfaceRequest<Request>& SurfaceRequest<Request>::operator=(const SurfaceRequest& other) {
  *impl_ = *other.impl_;
  return *this;
}
template <class Request>
SurfaceRequest<Request>::~SurfaceRequest() = default;

template <class Request>
Request& SurfaceRequest<Request>::max_edge(double length) {
  impl_->options.max_edge = length;
  return static_cast<Request&>(*this);
}
template <class Request>
Request& SurfaceRequest<Request>::max_radius(double length) {
  impl_->options.max_radius = length;
  return static_cast<Request&>(*this);
}
template <class Request>
Request& SurfaceRequest<Request>::value(const std::string& name) {
  impl_->options.value = name;
  return static_cast<Request&>(*this);
}
template <class Request>
Request& SurfaceRequest<Request>::overwrite(bool overwrite) {
  impl_->overwrite = overwrite;
  return static_cast<Request&>(*this);
}
template <class Request>
Request& SurfaceRequest<Request>::memory_bytes(std::uint64_t bytes) {
  impl_->options.memory_bytes = bytes;
  return static_cast<Request&>(*this);
}
template <class Request>
Request& SurfaceRequest<Request>::stop(std::stop_token stop) {
  impl_->stop = std::move(stop);
  return static_cast<Request&>(*this);
}

}  // namespace tessera
