// Logs refused requests. Frequent requests do not fill the log.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <unordered_map>

namespace tessera::service::http {

// For each caller ("who from where") logs one line a second, and then the number of further refusals; for at most
// `callers_max` callers. Thread-safe.
class RefusalLog {
 public:
  using Clock = std::chrono::steady_clock;
  using Write = std::function<void(const std::string& line)>;
  static constexpr std::size_t callers_max = 64;

  explicit RefusalLog(Write write) : write_(std::move(write)) {}
  void refused(const std::string& caller, const std::string& line, Clock::time_point now);
  // Call this about every second: logs the counts of callers whose second is over.
  void tell(Clock::time_point now);

 private:
  struct Told {
    Clock::time_point at;
    std::uint64_t more = 0;
  };
  const Write write_;
  std::mutex mutex_;
  std::unordered_map<std::string, Told> told_;
  std::uint64_t elsewhere_ = 0;  // refusals of further callers
};

}  // namespace tessera::service::http
