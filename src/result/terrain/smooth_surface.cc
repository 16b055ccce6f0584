#include "src/result/terrain/smooth_surface.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "src/base/option.h"

namespace tessera::terrain {
namespace {

constexpr std::int64_t samples_a_node = 4;  // samples along a side of a square
constexpr std::int64_t reach = 4;           // samples on each side of a node

// The weights of samples by their distance from the node, in eighths.
constexpr double weights[reach] = {7, 5, 3, 1};
constexpr double weight_of_all = 2 * 16.0 * 2 * 16.0;

// All squares that meet the closed box.
Lattice lattice_over(double res, const Bounds& box) {
  const auto first = [&](double c) { return static_cast<std::int64_t>(std::ceil(c / res)) - 1; };
  const auto last = [&](double c) { return static_cast<std::int64_t>(std::floor(c / res)); };
  Lattice nodes{.res = res, .column0 = first(box.lo.x), .row0 = first(box.lo.y)};
  nodes.width = last(box.hi.x) - nodes.column0 + 2;
  nodes.height = last(box.hi.y) - nodes.row0 + 2;
  return nodes;
}

// `node` is the sample above and to the right of the node; `across` is the number of samples in a row.
double mean_around(const double* node, std::int64_t across) {
  double sum = 0, weight = 0;
  for (std::int64_t y = 0; y < reach; ++y) {
    for (std::int64_t x = -reach; x < reach; ++x) {
      const double one = node[y * across + x], opposite = node[(-1 - y) * across - 1 - x];
      const double both = one + opposite;
      if (!std::isfinite(both)) continue;
      const double share = weights[y] * weights[x < 0 ? -1 - x : x];
      sum += share * both;
      weight += 2 * share;
    }
  }
  return weight * 2 >= weight_of_all ? sum / weight : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

Bounds around(const Bounds& box, double res) {
  return {{box.lo.x - 2 * res, box.lo.y - 2 * res, 0}, {box.hi.x + 2 * res, box.hi.y + 2 * res, 0}};
}

Result<SmoothPlan> plan_smooth(const ContourOptions& options, const Bounds& vertices) {
  const double res = *options.smooth;
  if (!(std::isfinite(res) && res > 0))
    return error(Errc::usage, option("smooth") + ": must be a length, finite and above 0");
  Bounds asked = options.box.value_or(vertices);
  for (const int axis : {0, 1}) {
    asked.lo[axis] = std::max(asked.lo[axis], vertices.lo[axis]);
    asked.hi[axis] = std::min(asked.hi[axis], vertices.hi[axis]);
  }
  SmoothPlan plan;
  plan.around = around(asked, res);
  BOOST_OUTCOME_TRY(samples, grid_over(res / samples_a_node, plan.around, vertices, "smooth"));
  plan.samples = samples;
  const auto count = static_cast<std::uint64_t>(samples.width) * static_cast<std::uint64_t>(samples.height);
  if (options.samples_max > 0 && count > options.samples_max)
    return error(Errc::memory, "a smooth surface takes " + std::to_string(count) + " samples here, more than " +
                                   std::to_string(options.samples_max) + ": ask for a smaller " + option("bbox") +
                                   " or a larger " + option("smooth"));
  plan.whole = lattice_over(res, vertices);
  plan.nodes = lattice_over(res, asked);
  if (static_cast<double>(plan.whole.width) * static_cast<double>(plan.whole.height) > 0x1p62)
    return error(Errc::usage, option("smooth") + ": is too small for bounds as large as those of the result");
  return plan;
}

Status SmoothSurface::read(const Lattice& part, std::vector<double>& values) {
  const Grid window{.res = samples_.grid().res,
                    .column0 = part.column0 * samples_a_node - reach,
                    .row0 = part.row0 * samples_a_node - reach,
                    .width = (part.width - 1) * samples_a_node + 2 * reach,
                    .height = (part.height - 1) * samples_a_node + 2 * reach};
  BOOST_OUTCOME_TRYV(samples_.read(window, window_));
  values.resize(static_cast<std::size_t>(part.width * part.height));
  constexpr double parts = 0x1p20;
  for (std::int64_t row = 0; row < part.height; ++row) {
    for (std::int64_t column = 0; column < part.width; ++column) {
      const double* node =
          window_.data() + (row * samples_a_node + reach) * window.width + column * samples_a_node + reach;
      const double number = (mean_around(node, window.width) - levels_.base()) / levels_.interval();
      values[static_cast<std::size_t>(row * part.width + column)] = (std::round(number * parts) + 0.5) / parts;
    }
  }
  return success();
}

std::vector<Lattice> parts_of(const Lattice& nodes) {
  std::vector<Lattice> parts;
  for (std::int64_t row = 0; row + 1 < nodes.height; row += part_squares) {
    for (std::int64_t column = 0; column + 1 < nodes.width; column += part_squares) {
      parts.push_back({.res = nodes.res,
                       .column0 = nodes.column0 + column,
                       .row0 = nodes.row0 + row,
                       .width = std::min(part_squares, nodes.width - 1 - column) + 1,
                       .height = std::min(part_squares, nodes.height - 1 - row) + 1});
    }
  }
  return parts;
}

}  // namespace tessera::terrain
