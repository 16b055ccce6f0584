#include "src/job/report/progress_display.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <new>

#include "src/base/printable.h"

namespace tessera {
namespace {

constexpr std::chrono::milliseconds tick{200};

int columns_of(std::FILE* out) {
  winsize size{};
  if (ioctl(fileno(out), TIOCGWINSZ, &size) == 0 && size.ws_col > 0) return size.ws_col;
  return 80;
}

double interval_s(ProgressStyle style) {
  switch (style) {
    case ProgressStyle::lines:
      return 5;
    case ProgressStyle::json:
      return 1;
    default:
      return 0;
  }
}

}  // namespace

ProgressDisplay::ProgressDisplay(const Progress& progress, ProgressStyle style, std::FILE* out, double elapsed_before_s)
    : progress_(progress),
      style_(style),
      out_(out),
      start_(std::chrono::steady_clock::now() - std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                                                    std::chrono::duration<double>(elapsed_before_s))) {
  if (style_ != ProgressStyle::none) thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

ProgressDisplay::~ProgressDisplay() { stop(); }

void ProgressDisplay::stop() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
}

double ProgressDisplay::elapsed_s() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

void ProgressDisplay::run(const std::stop_token& stop) {
  while (true) {
    {
      std::unique_lock lock(mutex_);
      wake_.wait_for(lock, stop, tick, [] { return false; });
    }
    if (stop.stop_requested()) break;
    try {
      const auto now = look(progress_, elapsed_s());
      if (style_ == ProgressStyle::terminal || now.phase != shown_phase_ ||
          now.elapsed_s - shown_s_ >= interval_s(style_)) {
        show(now);
      }
    } catch (const std::bad_alloc&) {  // the job itself reports it
    }
  }
  erase_panel();
}

void ProgressDisplay::show(const ProgressSnapshot& now) {
  if (style_ == ProgressStyle::terminal) {
    const auto lines = progress_panel(before_, now, columns_of(out_) - 1);
    erase_panel();
    for (const auto& line : lines) std::fprintf(out_, "%s\n", printable(line).c_str());
    panel_lines_ = static_cast<int>(lines.size());
  } else {
    const auto text =
        style_ == ProgressStyle::json ? progress_json(before_, now) : printable(progress_text(before_, now));
    std::fprintf(out_, "%s\n", text.c_str());
  }
  std::fflush(out_);
  // A rate over two seconds or more is readable; over one tick it flickers.
  if (now.phase != before_.phase || now.elapsed_s - before_.elapsed_s >= 2) before_ = now;
  shown_phase_ = now.phase;
  shown_s_ = now.elapsed_s;
}

void ProgressDisplay::erase_panel() {
  if (panel_lines_ == 0) return;
  std::fprintf(out_, "\033[%dA\r\033[J", panel_lines_);  // up, to the left, clear to the end of the screen
  std::fflush(out_);
  panel_lines_ = 0;
}

}  // namespace tessera
