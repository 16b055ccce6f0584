// What is asked of the surface of a 2D result, whatever is drawn of it: rasters, contour lines, profiles.
#pragma once

#include <cstdint>
#include <memory>
#include <stop_token>
#include <string>

#include "tessera/visibility.h"

namespace tessera {

// `Request`: the class made of it, which its functions return.
template <class Request>
class SurfaceRequest {
 public:
  SurfaceRequest(const SurfaceRequest&);
  SurfaceRequest& operator=(const SurfaceRequest&);
  ~SurfaceRequest();

  // Without the cells that have a longer edge in the plane: they bridge gaps.
  Request& max_edge(double length);
  // An attribute of the vertices; "z", the heights, by default.
  Request& value(const std::string& name);
  // Replace a file of the same name.
  Request& overwrite(bool overwrite);
  // For tiles and what is drawn of them; 0: 70 % of what is free.
  Request& memory_bytes(std::uint64_t bytes);
  Request& stop(std::stop_token stop);

 protected:
  SurfaceRequest();

  friend struct OptionsInside;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera
