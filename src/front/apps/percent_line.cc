#include "src/front/apps/percent_line.h"

#include <unistd.h>

#include <cstdio>

#include "src/job/report/human.h"

namespace tessera::apps {
namespace {

bool is_shown(const OutputOptions& output) {
  return !output.quiet && !output.json && !output.verbose && isatty(STDERR_FILENO) != 0;
}

}  // namespace

std::function<void(std::uint64_t, std::uint64_t)> percent_line(const std::string& what, const OutputOptions& output) {
  if (!is_shown(output)) return [](std::uint64_t, std::uint64_t) {};
  return [what, shown = -1](std::uint64_t bytes, std::uint64_t total) mutable {
    if (total == 0) return;
    const int percent = static_cast<int>(100.0 * static_cast<double>(bytes) / static_cast<double>(total));
    if (percent == shown) return;
    shown = percent;
    std::fprintf(stderr, "\r\x1b[K%s %d %% of %s", what.c_str(), percent, human_bytes(total).c_str());
  };
}

std::function<void(double)> share_line(const std::string& what, const OutputOptions& output) {
  if (!is_shown(output)) return {};
  return [what, shown = -1](double part) mutable {
    const int percent = static_cast<int>(100 * part);
    if (percent == shown) return;
    shown = percent;
    std::fprintf(stderr, "\r\x1b[K%s %d %%", what.c_str(), percent);
  };
}

void clear_line(const OutputOptions& output) {
  if (is_shown(output)) std::fprintf(stderr, "\r\x1b[K");
}

}  // namespace tessera::apps
