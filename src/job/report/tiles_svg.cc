#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "src/job/report/html_report.h"
#include "src/job/report/human.h"

namespace tessera {
namespace {

constexpr double size_max = 460;
constexpr std::size_t tiles_drawn_max = 20'000;  // more tiles would be smaller than a pixel

// From dark violet over green to yellow, so that it is readable in print and by colour-blind people. Linear between the
// stops.
constexpr std::array<std::array<double, 3>, 5> stops{
    {{62, 38, 110}, {49, 93, 151}, {35, 148, 145}, {106, 195, 96}, {247, 226, 58}}};

std::string colour(double t) {
  const double position = std::clamp(std::isfinite(t) ? t : 0.0, 0.0, 1.0) * (stops.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(position), stops.size() - 2);
  std::string text = "rgb(";
  for (std::size_t c = 0; c < 3; ++c) {
    const double value = stops[i][c] + (stops[i + 1][c] - stops[i][c]) * (position - static_cast<double>(i));
    text += (c > 0 ? "," : "") + fixed(value, 0);
  }
  return text + ")";
}

}  // namespace

std::string palette_gradient() {
  std::string css = "linear-gradient(to right";
  for (std::size_t i = 0; i < stops.size(); ++i) {
    css += "," + colour(static_cast<double>(i) / static_cast<double>(stops.size() - 1));
  }
  return css + ")";
}

std::string tiles_svg(const ReportData& data, int across, int up, const std::vector<double>& values) {
  if (data.tiles.empty() || data.bounds.empty()) return "";
  const double extent_x = data.bounds.hi[across] - data.bounds.lo[across];
  const double extent_y = data.bounds.hi[up] - data.bounds.lo[up];
  const double extent = std::max(extent_x, extent_y);
  if (!(extent > 0) || !std::isfinite(extent)) return "";
  const double scale = size_max / extent;
  // A very flat cloud is drawn at least 30 units high, so that it can be seen.
  const double width = std::max(30.0, extent_x * scale);
  const double height = std::max(30.0, extent_y * scale);
  const auto x_of = [&](double x) {
    return extent_x > 0
               ? width * (std::clamp(x, data.bounds.lo[across], data.bounds.hi[across]) - data.bounds.lo[across]) /
                     extent_x
               : 0;
  };
  const auto y_of = [&](double y) {
    return extent_y > 0
               ? height * (data.bounds.hi[up] - std::clamp(y, data.bounds.lo[up], data.bounds.hi[up])) / extent_y
               : 0;
  };
  const double most = *std::max_element(values.begin(), values.end());

  // Nearer tiles are drawn over those behind them.
  const int depth = 3 - across - up;
  std::vector<std::size_t> order(data.tiles.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const double sign = depth == 2 ? 1 : -1;  // from above; from the front
    return sign * std::max(data.tiles[a].box.lo[depth], data.bounds.lo[depth]) <
           sign * std::max(data.tiles[b].box.lo[depth], data.bounds.lo[depth]);
  });
  if (order.size() > tiles_drawn_max) order.resize(tiles_drawn_max);

  std::string svg = "<svg class=\"tiles\" viewBox=\"-2 -2 " + fixed(width + 4, 1) + " " + fixed(height + 4, 1) +
                    "\" style=\"max-width:" + fixed(width + 4, 0) + "px\" role=\"img\" aria-label=\"Tiles\">\n";
  for (const auto i : order) {
    const auto& tile = data.tiles[i];
    const double x0 = x_of(tile.box.lo[across]), x1 = x_of(tile.box.hi[across]);
    const double y0 = y_of(tile.box.hi[up]), y1 = y_of(tile.box.lo[up]);
    const double t = most > 0 ? values[i] / most : 0;
    svg += "<rect x=\"" + fixed(x0, 2) + "\" y=\"" + fixed(y0, 2) + "\" width=\"" + fixed(std::max(0.5, x1 - x0), 2) +
           "\" height=\"" + fixed(std::max(0.5, y1 - y0), 2) + "\" fill=\"" + colour(t) + "\"><title>tile " +
           to_string(tile.tile) + ": " + grouped(tile.points) + " points, " + grouped(tile.cells) + " cells, " +
           human_seconds(tile.seconds) + "</title></rect>\n";
  }
  return svg + "</svg>\n";
}

}  // namespace tessera
