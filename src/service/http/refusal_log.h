// What the log is told of those who are refused: who asks often does not fill it.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <unordered_map>

namespace tessera::http {

// Of each caller, "who from where", a line a second and then how many more there were; of many callers no more than
// `callers_max`. Safe from any thread.
class RefusalLog {
 public:
  using Clock = std::chrono::steady_clock;
  using Write = std::function<void(const std::string& line)>;
  static constexpr std::size_t callers_max = 64;

  explicit RefusalLog(Write write) : write_(std::move(write)) {}
  void refused(const std::string& caller, const std::string& line, Clock::time_point now);
  // To be called every second or so: tells what has not been told of those whose second is over.
  void tell(Clock::time_point now);

 private:
  struct Told {
    Clock::time_point at;
    std::uint64_t more = 0;
  };
  const Write write_;
  std::mutex mutex_;
  std::unordered_map<std::string, Told> told_;
  std::uint64_t elsewhere_ = 0;  // of callers for whom there was no room
};

}  // namespace tessera::http
