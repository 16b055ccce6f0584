// Watches a process of the daemon, and writes to its log when the process takes no jobs any more, when it takes jobs
// again, and when its certificate ends soon.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace tessera::daemon {

class ProcessWatch {
 public:
  // `unready` returns the reason why the process is not ready, as for /readyz; objects that it uses must outlive this
  // one. `certificate`: that of the cluster; empty without a cluster. `certificate_end_s`: when it ends, in seconds
  // since 1970.
  ProcessWatch(std::function<std::optional<std::string>()> unready, std::filesystem::path certificate,
               std::uint64_t certificate_end_s);

 private:
  void watch(const std::stop_token& stop);
  void look_at_certificate() const;
  void look_whether_ready();

  std::function<std::optional<std::string>()> unready_;
  std::filesystem::path certificate_;
  std::uint64_t certificate_end_s_;
  bool ready_ = true;  // as the log said last
  std::mutex mutex_;
  std::condition_variable_any stopped_;
  // A thread of its own, because the data folder may be on a file server that does not answer. It is the last member,
  // so that it ends before the others are destroyed.
  std::jthread thread_;
};

}  // namespace tessera::daemon
