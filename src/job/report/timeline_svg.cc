#include <algorithm>
#include <cmath>
#include <map>

#include "src/base/phases.h"
#include "src/job/report/html_report.h"
#include "src/job/report/human.h"

namespace tessera {
namespace {

constexpr double row = 22, gap = 6, top = 6, pixels = 1000;
constexpr int label_px = 72;  // left of the drawing; report_style.cc leaves as much room

// Returns the spans of one thread, merged where neither their ends nor the pauses between them could be seen.
std::vector<PhaseSpan> merge(std::vector<PhaseSpan> spans, double pixel_s) {
  std::sort(spans.begin(), spans.end(), [](const PhaseSpan& a, const PhaseSpan& b) { return a.begin_s < b.begin_s; });
  std::vector<PhaseSpan> bars;
  for (const auto& span : spans) {
    if (!bars.empty() && bars.back().phase == span.phase && span.begin_s - bars.back().end_s < pixel_s &&
        (bars.back().tile == span.tile || span.end_s - span.begin_s < 2 * pixel_s)) {
      bars.back().end_s = std::max(bars.back().end_s, span.end_s);
      bars.back().times += span.times;
    } else {
      bars.push_back(span);
    }
  }
  return bars;
}

// Returns a round number of seconds that divides the axis into four to ten parts.
double tick_of(double total_s) {
  const double power = std::pow(10, std::floor(std::log10(std::max(total_s, 1e-3))));
  for (const double step : {0.1, 0.2, 0.5, 1.0}) {
    if (total_s / (power * step) <= 10) return power * step;
  }
  return power;
}

}  // namespace

std::string timeline_svg(const std::vector<PhaseSpan>& spans, double total_s) {
  if (spans.empty()) return "";
  std::map<std::uint32_t, std::vector<PhaseSpan>> threads;
  for (const auto& span : spans) {
    threads[span.thread].push_back(span);
    total_s = std::max(total_s, span.end_s);
  }
  const auto at = [&](double seconds) { return 100 * seconds / std::max(total_s, 1e-9); };  // per cent
  const double height = top + static_cast<double>(threads.size()) * (row + gap) + 24;

  std::string svg = "<svg class=\"timeline\" style=\"height:" + fixed(height, 0) +
                    "px\" role=\"img\" aria-label=\"Timeline of threads\">\n";
  const double tick = tick_of(total_s);
  for (int i = 0; i * tick <= total_s; ++i) {
    const double x = at(i * tick);
    const char* const anchor = i == 0 ? "start" : x > 97 ? "end" : "middle";
    svg += "<line class=\"tick\" x1=\"" + fixed(x, 2) + "%\" x2=\"" + fixed(x, 2) + "%\" y1=\"0\" y2=\"" +
           fixed(height - 20, 1) + "\"/><text" + (i % 2 == 1 ? " class=\"between\"" : "") + " x=\"" + fixed(x, 2) +
           "%\" y=\"" + fixed(height - 6, 1) + "\" text-anchor=\"" + anchor + "\">" +
           fixed(i * tick, tick < 0.1 ? 2
                           : tick < 1 ? 1
                                      : 0) +
           " s</text>\n";
  }
  double y = top;
  for (const auto& [thread, list] : threads) {
    svg += "<text x=\"" + std::to_string(-label_px) + "\" y=\"" + fixed(y + row * 0.7, 1) + "\">thread " +
           std::to_string(thread) + "</text>\n";
    for (const auto& bar : merge(list, total_s / pixels)) {
      const double x = at(bar.begin_s);
      const std::string what = bar.times == 1 || row_of(bar.phase).step == StageStep::begin
                                   ? "tile " + to_string(bar.tile)
                                   : std::to_string(bar.times) + " times";
      svg += "<rect class=\"p-" + std::string(name_of(bar.phase)) + "\" x=\"" + fixed(x, 3) + "%\" y=\"" + fixed(y, 1) +
             "\" width=\"" + fixed(std::max(0.06, at(bar.end_s) - x - 0.04), 3) + "%\" height=\"" + fixed(row, 0) +
             "\"><title>" + row_of(bar.phase).label + ", " + what + ": " + fixed(bar.begin_s, 3) + " to " +
             fixed(bar.end_s, 3) + " s</title></rect>\n";
    }
    y += row + gap;
  }
  return svg + "</svg>\n";
}

}  // namespace tessera
