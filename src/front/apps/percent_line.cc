#include "src/front/apps/percent_line.h"

#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "src/base/json/json_text.h"
#include "src/job/report/human.h"

namespace tessera::apps {
namespace {

bool is_shown(const OutputOptions& output) {
  return !output.quiet && !output.json && !output.verbose && isatty(STDERR_FILENO) != 0;
}

// Prints events of progress, in the form of those of a job: the first after a second, so that short work has none, and
// then at most two a second.
class ProgressEvents {
 public:
  explicit ProgressEvents(std::string phase) : phase_(std::move(phase)) {}
  void tell(double fraction) {
    const auto now = std::chrono::steady_clock::now();
    if (now < next_) return;
    next_ = now + std::chrono::milliseconds(500);
    const nlohmann::ordered_json event = {{"event", "progress"}, {"phase", phase_}, {"fraction", fraction}};
    std::printf("%s\n", json_text(event).c_str());
    std::fflush(stdout);
  }

 private:
  std::string phase_;
  std::chrono::steady_clock::time_point next_ = std::chrono::steady_clock::now() + std::chrono::seconds(1);
};

bool tells_events(const OutputOptions& output) { return output.json && !output.quiet; }

}  // namespace

std::function<void(std::uint64_t, std::uint64_t)> percent_line(const std::string& what, const OutputOptions& output) {
  if (tells_events(output)) {
    return [events = ProgressEvents(what)](std::uint64_t bytes, std::uint64_t total) mutable {
      if (total > 0) events.tell(static_cast<double>(bytes) / static_cast<double>(total));
    };
  }
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
  if (tells_events(output)) return [events = ProgressEvents(what)](double part) mutable { events.tell(part); };
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
