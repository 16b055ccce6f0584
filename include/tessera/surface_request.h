// The options that all drawings of the surface of a 2D result share: rasters, contour lines, profiles.
#pragma once

#include <cstdint>
#include <memory>
#include <stop_token>
#include <string>

#include "tessera/visibility.h"

namespace tessera {

// `Request` is the derived class. Every function returns *this as a Request.
template <class Request>
class SurfaceRequest {
 public:
  SurfaceRequest(const SurfaceRequest&);
  SurfaceRequest& operator=(const SurfaceRequest&);
  ~SurfaceRequest();

  // Leaves out cells with a longer edge in the plane: such cells bridge gaps between the points.
  Request& max_edge(double length);
  // Leaves out cells with a larger circumradius in the plane, compared exactly.
  Request& max_radius(double length);
  // The attribute of the vertices that is drawn; by default "z", the heights.
  Request& value(const std::string& name);
  // Replaces an existing file of the same name.
  Request& overwrite(bool overwrite);
  // The memory for tiles and for what is drawn; 0, the default: 70 % of the free memory.
  Request& memory_bytes(std::uint64_t bytes);
  Request& stop(std::stop_token stop);

 protected:
  SurfaceRequest();

  friend struct OptionsInside;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera
