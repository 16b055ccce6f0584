#include "src/front/daemon/process_watch.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <utility>

#include "src/base/thread_name.h"
#include "src/cluster/certs/certificates.h"

namespace tessera::daemon {
namespace {

using std::chrono::system_clock;

constexpr std::chrono::seconds between_looks{2};
constexpr std::chrono::hours day{24};

}  // namespace

ProcessWatch::ProcessWatch(std::function<std::optional<std::string>()> unready, std::filesystem::path certificate,
                           std::uint64_t certificate_end_s)
    : unready_(std::move(unready)),
      certificate_(std::move(certificate)),
      certificate_end_s_(certificate_end_s),
      thread_([this](const std::stop_token& stop) { watch(stop); }) {}

void ProcessWatch::watch(const std::stop_token& stop) {
  name_thread("watch");
  auto certificate_looked_at = std::chrono::steady_clock::now();
  look_at_certificate();
  while (!stop.stop_requested()) {
    look_whether_ready();
    if (std::chrono::steady_clock::now() - certificate_looked_at >= day) {
      certificate_looked_at = std::chrono::steady_clock::now();
      look_at_certificate();
    }
    std::unique_lock lock(mutex_);
    stopped_.wait_for(lock, stop, between_looks, [] { return false; });
  }
}

void ProcessWatch::look_at_certificate() const {
  if (certificate_end_s_ == 0) return;
  const system_clock::time_point end{std::chrono::seconds(certificate_end_s_)};
  const std::string warning = expiry_warning(end, system_clock::now());
  if (!warning.empty()) spdlog::warn("{}: {}", certificate_.string(), warning);
}

void ProcessWatch::look_whether_ready() {
  const auto why = unready_();
  if (!why == ready_) return;
  ready_ = !why;
  if (why) spdlog::warn("this process is not ready any more: {}", *why);
  if (!why) spdlog::info("this process is ready again");
}

}  // namespace tessera::daemon
