// Transforms coordinates of a system to longitude and latitude (CRS84 of OGC), and back.
#pragma once

#include <span>
#include <string>

#include "src/base/crs/gdal_library.h"
#include "src/base/point.h"

namespace tessera {

// A transformation. Only one thread at a time may use it.
class LonLat {
 public:
  // Makes the transformation of a system. Errors: bad_input when `crs` does not say where on the earth x and y are, or
  // GDAL does not understand it; io without GDAL.
  static Result<LonLat> of(const std::string& crs);
  LonLat(LonLat&& other) noexcept;
  LonLat& operator=(LonLat&&) = delete;
  ~LonLat();

  // Transform x and y in place. Error bad_input when one of the points cannot be transformed.
  Status to(std::span<Point> points) const;
  Status from(std::span<Point> points) const;
  // Transform a box: they return a box of the other system that contains the given box. Points on the border are
  // transformed, and the result is made a little wider.
  Result<Bounds> box_to(const Bounds& box) const { return box_by(box, true); }
  Result<Bounds> box_from(const Bounds& box) const { return box_by(box, false); }
  // The horizontal system, as WKT.
  const std::string& wkt() const { return wkt_; }

 private:
  LonLat(const GdalLibrary& gdal, OGRCoordinateTransformationH to, OGRCoordinateTransformationH from, std::string wkt)
      : gdal_(gdal), to_(to), from_(from), wkt_(std::move(wkt)) {}
  Status transform(OGRCoordinateTransformationH how, std::span<Point> points) const;
  Result<Bounds> box_by(const Bounds& box, bool to) const;

  const GdalLibrary& gdal_;
  OGRCoordinateTransformationH to_, from_;
  std::string wkt_;
};

}  // namespace tessera
