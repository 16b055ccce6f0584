// Places of a coordinate system as longitude and latitude (OGC's CRS84), and back.
#pragma once

#include <span>
#include <string>

#include "src/base/crs/gdal_library.h"
#include "src/base/point.h"

namespace tessera {

// Of one thread at a time.
class LonLat {
 public:
  // Error bad_input when nothing, or nothing that GDAL understands, says where on the earth x and y are; io without
  // GDAL.
  static Result<LonLat> of(const std::string& crs);
  LonLat(LonLat&& other) noexcept;
  LonLat& operator=(LonLat&&) = delete;
  ~LonLat();

  // x and y in place. Error bad_input when one of them has none.
  Status to(std::span<Point> points) const;
  Status from(std::span<Point> points) const;
  // Of a box that is bounded by lines of the one system, the box in the other: by points of its border, and a little
  // wider.
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
