// What a process of the daemon says in its log by itself: that it takes no jobs any more, or takes them again; that its
// certificate ends soon.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace tessera {

class ProcessWatch {
 public:
  // `unready`: as of /readyz; outlives this. `certificate`: of the cluster; none: no cluster.
  ProcessWatch(std::function<std::optional<std::string>()> unready, std::filesystem::path certificate,
               std::uint64_t certificate_end_s);

 private:
  void watch(const std::stop_token& stop);
  void look_at_certificate() const;
  void look_whether_ready();

  std::function<std::optional<std::string>()> unready_;
  std::filesystem::path certificate_;
  std::uint64_t certificate_end_s_;
  bool ready_ = true;  // as told last
  std::mutex mutex_;
  std::condition_variable_any stopped_;
  // Of its own: the folder that is looked at may be one of a file server that does not answer. Last: it ends first.
  std::jthread thread_;
};

}  // namespace tessera
