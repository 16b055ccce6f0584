#include "src/service/http/refusal_log.h"

#include <utility>
#include <vector>

namespace tessera::service::http {
namespace {

constexpr std::chrono::seconds between{1};

std::string refusals(std::uint64_t count) {
  return "and " + std::to_string(count) + " more " + (count == 1 ? "refusal" : "refusals");
}

}  // namespace

void RefusalLog::refused(const std::string& caller, const std::string& line, Clock::time_point now) {
  std::string text = line;
  {
    const std::scoped_lock lock(mutex_);
    const auto known = told_.find(caller);
    if (known == told_.end() && told_.size() >= callers_max) {
      ++elsewhere_;
      return;
    }
    Told& told = known == told_.end() ? told_[caller] : known->second;
    if (known != told_.end() && now - told.at < between) {
      ++told.more;
      return;
    }
    if (told.more > 0) text += "; " + refusals(told.more) + " before it";
    told = {now, 0};
  }
  write_(text);
}

void RefusalLog::tell(Clock::time_point now) {
  std::vector<std::string> lines;
  {
    const std::scoped_lock lock(mutex_);
    for (auto at = told_.begin(); at != told_.end();) {
      if (now - at->second.at < between) {
        ++at;
        continue;
      }
      if (at->second.more > 0) lines.push_back("audit: " + at->first + ": " + refusals(at->second.more));
      at = told_.erase(at);
    }
    if (elsewhere_ > 0) lines.push_back("audit: others: " + refusals(std::exchange(elsewhere_, 0)));
  }
  for (const std::string& line : lines) write_(line);
}

}  // namespace tessera::service::http
