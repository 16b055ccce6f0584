#include "src/base/progress.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <tuple>

namespace tessera {
namespace {

constexpr std::size_t spans_max = 50'000;
constexpr double parts_of_the_whole = 4096;  // a resolution finer than any screen

void merge(std::vector<PhaseSpan>& spans, double short_s) {
  const auto order = [](const PhaseSpan& s) { return std::tuple(s.thread, s.phase, s.begin_s); };
  std::sort(spans.begin(), spans.end(), [&](const PhaseSpan& a, const PhaseSpan& b) { return order(a) < order(b); });
  std::size_t kept = 0;
  for (const PhaseSpan& span : spans) {
    PhaseSpan* const last = kept > 0 ? &spans[kept - 1] : nullptr;
    if (last && last->thread == span.thread && last->phase == span.phase && span.begin_s - last->end_s < short_s &&
        span.end_s - span.begin_s < short_s) {
      last->end_s = std::max(last->end_s, span.end_s);
      last->times += span.times;
    } else {
      spans[kept++] = span;
    }
  }
  spans.resize(kept);
}

}  // namespace

void Timeline::add(const PhaseSpan& span) {
  spans_.push_back(span);
  if (spans_.size() < spans_max) return;
  short_s_ = std::max({short_s_, span.end_s / parts_of_the_whole, 1e-6});
  for (merge(spans_, short_s_); spans_.size() > spans_max / 2; merge(spans_, short_s_)) short_s_ *= 2;
}

BusyThreads Timeline::busy(std::size_t parts) const {
  BusyThreads busy{0, std::vector<double>(parts)};
  for (const PhaseSpan& span : spans_) busy.until_s = std::max(busy.until_s, span.end_s);
  if (busy.until_s <= 0) return busy;
  const double part_s = busy.until_s / static_cast<double>(parts);
  for (const PhaseSpan& span : spans_) {
    const double last = static_cast<double>(parts) - 1;
    const double from = std::min(last, std::max(0.0, std::floor(span.begin_s / part_s)));
    const double to = std::min(last, std::floor(span.end_s / part_s));
    for (double part = from; part <= to; ++part) {
      const double both_s = std::min(span.end_s, (part + 1) * part_s) - std::max(span.begin_s, part * part_s);
      busy.threads[static_cast<std::size_t>(part)] += std::max(0.0, both_s) / part_s;
    }
  }
  return busy;
}

}  // namespace tessera
