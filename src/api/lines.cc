#include "tessera/lines.h"

#include <cmath>
#include <utility>

#include "src/api/errors.h"
#include "src/api/options_inside.h"
#include "src/base/option.h"
#include "src/files/there.h"
#include "src/files/whole_file.h"
#include "src/job/machine.h"
#include "src/query/stored_triangulation.h"
#include "src/terrain/contours.h"
#include "src/terrain/profile.h"

namespace tessera {

struct ContourRequest::Impl {
  ContourOptions options;
  std::stop_token stop;
};

ContourRequest::ContourRequest(double interval) : impl_(std::make_unique<Impl>()) {
  impl_->options = {.interval = interval, .memory_bytes = 0, .threads = 0};
}
ContourRequest::ContourRequest(const ContourRequest& other) : impl_(std::make_unique<Impl>(*other.impl_)) {}
ContourRequest& ContourRequest::operator=(const ContourRequest& other) {
  *impl_ = *other.impl_;
  return *this;
}
ContourRequest::~ContourRequest() = default;

ContourRequest& ContourRequest::base(double level) {
  impl_->options.base = level;
  return *this;
}
ContourRequest& ContourRequest::bbox(const std::array<double, 4>& box) {
  impl_->options.box = Bounds{{box[0], box[1], 0}, {box[2], box[3], 0}};
  return *this;
}
ContourRequest& ContourRequest::max_edge(double length) {
  impl_->options.max_edge = length;
  return *this;
}
ContourRequest& ContourRequest::value(const std::string& name) {
  impl_->options.value = name;
  return *this;
}
ContourRequest& ContourRequest::overwrite(bool overwrite) {
  impl_->options.overwrite = overwrite;
  return *this;
}
ContourRequest& ContourRequest::memory_bytes(std::uint64_t bytes) {
  impl_->options.memory_bytes = bytes;
  return *this;
}
ContourRequest& ContourRequest::threads(unsigned threads) {
  impl_->options.threads = threads;
  return *this;
}
ContourRequest& ContourRequest::stop(std::stop_token stop) {
  impl_->stop = std::move(stop);
  return *this;
}

struct ProfileRequest::Impl {
  ProfileOptions options;
  bool overwrite = false;
};

ProfileRequest::ProfileRequest() : impl_(std::make_unique<Impl>()) { impl_->options.memory_bytes = 0; }
ProfileRequest::ProfileRequest(const ProfileRequest& other) : impl_(std::make_unique<Impl>(*other.impl_)) {}
ProfileRequest& ProfileRequest::operator=(const ProfileRequest& other) {
  *impl_ = *other.impl_;
  return *this;
}
ProfileRequest::~ProfileRequest() = default;

ProfileRequest& ProfileRequest::max_edge(double length) {
  impl_->options.max_edge = length;
  return *this;
}
ProfileRequest& ProfileRequest::value(const std::string& name) {
  impl_->options.value = name;
  return *this;
}
ProfileRequest& ProfileRequest::overwrite(bool overwrite) {
  impl_->overwrite = overwrite;
  return *this;
}
ProfileRequest& ProfileRequest::memory_bytes(std::uint64_t bytes) {
  impl_->options.memory_bytes = bytes;
  return *this;
}
ProfileRequest& ProfileRequest::stop(std::stop_token stop) {
  impl_->options.stop = std::move(stop);
  return *this;
}

namespace {

ContourOptions chosen(ContourOptions options) {
  if (options.memory_bytes == 0) options.memory_bytes = default_memory();
  if (options.threads == 0) options.threads = usable_processors();
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

std::vector<ProfilePoint> profile_of(const Triangulation& triangulation, std::span<const double> line,
                                     ProfileOptions options) {
  const std::vector<Point> points = line_of(line);
  // Half for tiles, half for what is found in them.
  options.memory_bytes = (options.memory_bytes > 0 ? options.memory_bytes : default_memory()) / 2;
  const auto stored =
      value_or_throw(query::StoredTriangulation::open(triangulation.folder(), {.memory_bytes = options.memory_bytes}));
  return value_or_throw(profile(stored, triangulation.folder(), points, options));
}

}  // namespace

LineSet draw_contours(const Triangulation& triangulation, const ContourRequest& request) {
  return guarded([&] {
    const auto& asked = OptionsInside::of(request);
    ContourOptions options = chosen(asked.options);
    options.vertices_max = options.memory_bytes / 4 / (2 * sizeof(double));
    LineSet lines;
    lines.offsets.push_back(0);
    const auto take = [&](double value, std::span<const Point> points) {
      for (const Point& p : points) lines.points.insert(lines.points.end(), {p.x, p.y});
      lines.values.push_back(value);
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
    return value_or_throw(write_contours(triangulation.folder(), target, chosen(asked.options), asked.stop)).note;
  });
}

ProfileTable draw_profile(const Triangulation& triangulation, std::span<const double> line,
                          const ProfileRequest& request) {
  return guarded([&] {
    ProfileTable table;
    for (const ProfilePoint& p : profile_of(triangulation, line, OptionsInside::of(request).options)) {
      table.distances.push_back(p.distance);
      table.points.insert(table.points.end(), {p.x, p.y});
      table.values.push_back(p.value);
      table.parts.push_back(p.part);
    }
    return table;
  });
}

void write_profile(const Triangulation& triangulation, std::span<const double> line,
                   const std::filesystem::path& target, const ProfileRequest& request) {
  guarded([&] {
    const auto& asked = OptionsInside::of(request);
    if (value_or_throw(is_there(target)) && !asked.overwrite)
      throw_failure(
          error(Errc::usage, target.string() + ": exists already; " + option("overwrite", "true") + " replaces it"));
    or_throw(write_whole(target, to_csv(profile_of(triangulation, line, asked.options), asked.options.value)));
  });
}

}  // namespace tessera
