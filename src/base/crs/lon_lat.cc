#include "src/base/crs/lon_lat.h"

#include <cmath>
#include <utility>
#include <vector>

#include "src/base/crs/crs.h"
#include "src/base/default_arithmetic.h"

namespace tessera {
namespace {

Error no_place(const std::string& why) {
  return error(Errc::bad_input, "it is not known where on the earth the coordinates are: " + why);
}

}  // namespace

Result<LonLat> LonLat::of(const std::string& crs) {
  if (!looks_like_crs(crs)) return no_place("there is no coordinate system");
  BOOST_OUTCOME_TRY(gdal, gdal_library());
  const DefaultArithmetic kept;
  const GdalQuiet quiet(*gdal);
  BOOST_OUTCOME_TRY(system, SpatialReference::parse(*gdal, crs));
  if (gdal->OSRIsGeocentric(system.get()) != 0 || gdal->OSRIsLocal(system.get()) != 0)
    return no_place("the coordinate system is geocentric or local, so it has no map");
  gdal->OSRStripVertical(system.get());
  BOOST_OUTCOME_TRY(degrees, SpatialReference::parse(*gdal, "EPSG:4326"));
  char* text = nullptr;
  gdal->OSRExportToWkt(system.get(), &text);
  std::string wkt = text == nullptr ? "" : text;
  gdal->VSIFree(text);
  LonLat made(*gdal, gdal->OCTNewCoordinateTransformation(system.get(), degrees.get()),
              gdal->OCTNewCoordinateTransformation(degrees.get(), system.get()), std::move(wkt));
  if (made.to_ == nullptr || made.from_ == nullptr) return no_place(quiet.message());
  return made;
}

LonLat::LonLat(LonLat&& other) noexcept
    : gdal_(other.gdal_),
      to_(std::exchange(other.to_, nullptr)),
      from_(std::exchange(other.from_, nullptr)),
      wkt_(std::move(other.wkt_)) {}

LonLat::~LonLat() {
  if (to_ != nullptr) gdal_.OCTDestroyCoordinateTransformation(to_);
  if (from_ != nullptr) gdal_.OCTDestroyCoordinateTransformation(from_);
}

Status LonLat::to(std::span<Point> points) const { return transform(to_, points); }
Status LonLat::from(std::span<Point> points) const { return transform(from_, points); }

Status LonLat::transform(OGRCoordinateTransformationH how, std::span<Point> points) const {
  const DefaultArithmetic kept;
  const GdalQuiet quiet(gdal_);
  std::vector<double> x, y;
  for (const Point& p : points) {
    x.push_back(p.x);
    y.push_back(p.y);
  }
  const bool all = gdal_.OCTTransform(how, static_cast<int>(points.size()), x.data(), y.data(), nullptr) != 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!all || !std::isfinite(x[i]) || !std::isfinite(y[i]))
      return error(
          Errc::bad_input,
          "a point cannot be converted between longitude and latitude and the coordinate system: " + quiet.message());
    points[i].x = x[i];
    points[i].y = y[i];
  }
  return success();
}

Result<Bounds> LonLat::box_by(const Bounds& box, bool forward) const {
  constexpr int steps = 20;
  std::vector<Point> border;
  for (int i = 0; i <= steps; ++i) {
    const double part = static_cast<double>(i) / steps;
    const double x = std::lerp(box.lo.x, box.hi.x, part), y = std::lerp(box.lo.y, box.hi.y, part);
    for (const Point& p : {Point{x, box.lo.y, 0}, Point{x, box.hi.y, 0}, Point{box.lo.x, y, 0}, Point{box.hi.x, y, 0}})
      border.push_back(p);
  }
  BOOST_OUTCOME_TRYV(forward ? to(border) : from(border));
  Bounds around;
  for (const Point& p : border) around.add(p);
  // Between two points of the border a line may bulge by at most an eighth of the square of the step.
  const double x = (around.hi.x - around.lo.x) / (steps * steps), y = (around.hi.y - around.lo.y) / (steps * steps);
  around.lo.x -= x;
  around.hi.x += x;
  around.lo.y -= y;
  around.hi.y += y;
  return around;
}

}  // namespace tessera
