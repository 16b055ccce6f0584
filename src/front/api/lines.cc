#include "tessera/lines.h"

#include <cmath>
#include <utility>

#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/base/option.h"
#include "src/front/api/errors.h"
#include "src/front/api/options_inside.h"
#include "src/front/api/surface_request_inside.h"
#include "src/result/query/stored_triangulation.h"
#include "src/result/terrain/contours.h"
#include "src/result/terrain/profile.h"

namespace tessera {

template <>
struct AskedOfEngine<ContourRequest> {
  using Options = ContourOptions;
};
template <>
struct AskedOfEngine<ProfileRequest> {
  using Options = ProfileOptions;
};
template class SurfaceRequest<ContourRequest>;
template class SurfaceRequest<ProfileRequest>;

ContourRequest::ContourRequest(double interval) { impl_->options.interval = interval; }
ContourRequest& ContourRequest::base(double level) {
  impl_->options.base = level;
  return *this;
}
ContourRequest& ContourRequest::bbox(const std::array<double, 4>& box) {
  impl_->options.box = Bounds{{box[0], box[1], 0}, {box[2], box[3], 0}};
  return *this;
}
ContourRequest& ContourRequest::smooth(double size) {
  impl_->options.smooth = size;
  return *this;
}
ContourRequest& ContourRequest::min_length(double length) {
  impl_->options.min_length = length;
  return *this;
}
ContourRequest& ContourRequest::index_every(std::uint32_t levels) {
  impl_->options.index_every = levels;
  return *this;
}
ContourRequest& ContourRequest::threads(unsigned threads) {
  impl_->options.threads = threads;
  return *this;
}

ProfileRequest::ProfileRequest() = default;
ProfileRequest& ProfileRequest::digits(int decimals) {
  impl_->options.digits = decimals;
  return *this;
}
ProfileRequest& ProfileRequest::all_digits() { return digits(digits_all); }

namespace {

ContourOptions checked(ContourOptions options) {
  if (options.box) {
    const Bounds& box = *options.box;
    for (const double bound : {box.lo.x, box.lo.y, box.hi.x, box.hi.y})
      if (!std::isfinite(bound)) throw_failure(error(Errc::usage, option("bbox") + ": must be finite"));
    if (box.lo.x > box.hi.x || box.lo.y > box.hi.y)
      throw_failure(error(Errc::usage, option("bbox") + ": is an empty box"));
  }
  return options;
}

std::vector<Point> line_of(std::span<const double> coordinates) {
  const auto refuse = [](const std::string& why) { throw_failure(error(Errc::usage, option("line") + ": " + why)); };
  if (coordinates.size() % 2 != 0 || coordinates.size() < 4) refuse("must be x and y of two points or more");
  std::vector<Point> line(coordinates.size() / 2);
  for (std::size_t i = 0; i < line.size(); ++i) {
    line[i] = {coordinates[2 * i], coordinates[2 * i + 1], 0};
    if (!is_finite(line[i])) refuse("point " + std::to_string(i) + " is not finite");
  }
  return line;
}

std::vector<ProfilePoint> profile_of(const Triangulation& triangulation, std::span<const Point> points,
                                     ProfileOptions options) {
  // One half of the memory is for tiles, the other half for the points that are found in them.
  options.memory_bytes /= 2;
  const auto stored =
      value_or_throw(query::StoredTriangulation::open(triangulation.folder(), {.memory_bytes = options.memory_bytes}));
  return value_or_throw(profile(stored, triangulation.folder(), points, options));
}

}  // namespace

LineSet draw_contours(const Triangulation& triangulation, const ContourRequest& request) {
  return guarded([&] {
    const auto& asked = OptionsInside::of(request);
    ContourOptions options = checked(asked.chosen());
    options.vertices_max = options.memory_bytes / 4 / (2 * sizeof(double));
    LineSet lines;
    lines.offsets.push_back(0);
    const auto take = [&](const ContourLine& line) {
      for (const Point& p : line.points) lines.points.insert(lines.points.end(), {p.x, p.y});
      lines.values.push_back(line.value);
      lines.index.push_back(line.index ? 1 : 0);
      lines.offsets.push_back(lines.points.size() / 2);
    };
    or_throw(trace_contours(triangulation.folder(), options, take, asked.stop));
    return lines;
  });
}

std::string write_contours(const Triangulation& triangulation, const std::filesystem::path& target,
                           const ContourRequest& request) {
  return guarded([&] {
    const auto& asked = OptionsInside::of(request);
    return value_or_throw(write_contours(triangulation.folder(), target, checked(asked.chosen()), asked.stop)).note;
  });
}

ProfileTable draw_profile(const Triangulation& triangulation, std::span<const double> line,
                          const ProfileRequest& request) {
  return guarded([&] {
    ProfileTable table;
    for (const ProfilePoint& p : profile_of(triangulation, line_of(line), OptionsInside::of(request).chosen())) {
      table.distances.push_back(p.distance);
      table.points.insert(table.points.end(), {p.x, p.y});
      table.values.push_back(p.value);
      table.parts.push_back(p.part);
    }
    return table;
  });
}

std::string write_profile(const Triangulation& triangulation, std::span<const double> line,
                          const std::filesystem::path& target, const ProfileRequest& request) {
  return guarded([&] {
    const auto& asked = OptionsInside::of(request);
    if (value_or_throw(is_there(target)) && !asked.overwrite)
      throw_failure(
          error(Errc::usage, target.string() + ": exists already; " + option("overwrite", "true") + " replaces it"));
    const std::vector<Point> points = line_of(line);
    const auto profile = profile_of(triangulation, points, asked.chosen());
    or_throw(write_whole(target, to_csv(profile, asked.options)));
    return gaps_note(gaps_of(profile, points));
  });
}

}  // namespace tessera
