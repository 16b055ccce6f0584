#include "src/input/cloud/settle_period.h"

#include <array>
#include <cmath>
#include <cstdio>

#include "src/base/option.h"
#include "src/base/periodic_box.h"

namespace tessera {
namespace {

// The shortest digits that read back as the same double.
std::string digits(double value) {
  std::array<char, 40> text{};
  for (int precision = 1; precision <= 17; ++precision) {
    std::snprintf(text.data(), text.size(), "%.*g", precision, value);
    if (std::strtod(text.data(), nullptr) == value) break;
  }
  return text.data();
}

std::string rough(double value) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.2g", value);
  return text.data();
}

Error refuse(const std::string& reason) { return error(Errc::usage, option("periodic") + ": " + reason); }

// What is wrong with a number that is to be a period, as the end of a sentence; "" when nothing is.
std::string why_no_period(double length) {
  if (std::isnan(length)) return "is not a number";
  if (length < 0) return "is negative";
  if (std::isinf(length)) return "is infinite";
  if (length < least_period || length > greatest_period)
    return "is not between " + rough(least_period) + " and " + rough(greatest_period);
  return "";
}

}  // namespace

Status take_box_of_files(std::span<const FileInfo> files, CloudOptions& options) {
  if (!options.periodic_files) return success();
  if (!options.periodic.empty())
    return refuse("the box of the files and periods contradict each other: give one of them");
  const Point& box = files.front().box;
  for (const FileInfo& file : files) {
    if (file.box == Point{}) return refuse(file.path.string() + " states no box; give the periods as numbers");
    if (!(file.box == box))
      return refuse(file.path.string() + " states another box than " + files.front().path.string());
  }
  options.periodic = {box.x, box.y};
  if (options.dimension == 3) options.periodic.push_back(box.z);
  return success();
}

Status settle_period(CloudOptions& options, std::vector<std::string>& warnings) {
  options.period = {};
  const std::size_t given = options.periodic.size();
  if (given == 0) return success();
  const auto axes = static_cast<std::size_t>(options.dimension);
  if (given != 1 && given != axes)
    return refuse(std::to_string(given) + " periods are given; the cloud has " + std::to_string(axes) +
                  " axes, so give one period for all of them, or " + std::to_string(axes));
  for (std::size_t axis = 0; axis < axes; ++axis) {
    const double length = options.periodic[given == 1 ? 0 : axis];
    if (length == 0) continue;
    if (const auto reason = why_no_period(length); !reason.empty())
      return refuse("the period " + digits(length) + " " + reason);
    const double rounded = in_steps(length);
    if (rounded != length) {
      const std::string name = "the period " + digits(length) + " along " + "xyz"[axis];
      if (!options.snap)
        return refuse(name +
                      " has more than 51 binary digits, so images would be rounded; the nearest period that "
                      "has not is " +
                      digits(rounded) + " (" + option("periodic-snap", "yes") + " takes it)");
      warnings.push_back(name + " has more than 51 binary digits; it was rounded to " + digits(rounded));
    }
    options.period.length[axis] = rounded;
  }
  if (!options.period.any()) return refuse("all periods are 0");
  return success();
}

std::vector<std::string> sentences_of_period(const CloudCounts& counts, const Period& period) {
  std::vector<std::string> sentences;
  if (!period.any()) return sentences;
  if (counts.moved > 0)
    sentences.push_back(std::to_string(counts.moved) + (counts.moved == 1 ? " point was" : " points were") +
                        " moved by whole periods into the box that begins at 0");
  if (counts.snapped > 0)
    sentences.push_back("coordinates were rounded to multiples of the period's step, 2^-51 of the period or less, by " +
                        rough(counts.snapped) + " at most");
  return sentences;
}

std::string why_too_large(const CloudCounts& counts, const Period& period) {
  if (counts.snapped == 0 || counts.unmoved.empty()) return "";
  constexpr double least_steps = 16'777'216;  // with fewer, rounding shows at the precision of single floats
  for (int axis = 0; axis < 3; ++axis) {
    if (!period.along(axis)) continue;
    const double length = period.length[static_cast<std::size_t>(axis)];
    const double extent = counts.unmoved.hi[axis] - counts.unmoved.lo[axis];
    if (extent == 0 || extent >= least_steps * step_of(length)) continue;
    return std::string("the period ") + digits(length) + " along " + "xyz"[axis] +
           " is too large for points that lie within " + rough(extent) +
           " of each other: coordinates would be rounded to multiples of " + rough(step_of(length));
  }
  return "";
}

}  // namespace tessera
