#include "src/service/processes/workshop.h"

#include <condition_variable>
#include <mutex>
#include <utility>

#include "src/base/ledger.h"
#include "src/service/problem.h"

namespace tessera::service {

LockOptions lock_of_unfinished(const Workshop& shop, const std::stop_token& stop) {
  static constexpr std::chrono::milliseconds pause{200};
  const auto until = std::chrono::steady_clock::now() + shop.data_lease * 3 / 2;
  const auto wait = [stop, until](const Error&) {
    std::mutex mutex;
    std::condition_variable_any stopped;
    std::unique_lock lock(mutex);
    stopped.wait_for(lock, stop, pause, [&] { return stop.stop_requested(); });
    return !stop.stop_requested() && std::chrono::steady_clock::now() < until;
  };
  return {.heartbeat = shop.data_lease / 12, .silence_max = shop.data_lease, .locked = wait};
}

std::optional<proto::Problem> check_files(const Workshop& shop,
                                          const google::protobuf::RepeatedPtrField<std::string>& names,
                                          bool recursive) {
  const auto files = shop.roots.files(list_of(names), recursive);
  if (files || Ledger::reason_of_thread()) return std::nullopt;
  return problem_of_inputs(files.error());
}

proto::Problem in_callers_words(const Workshop& shop, proto::Problem problem) {
  return reworded(std::move(problem), [&](const std::string& sentence) { return shop.roots.named(sentence); });
}

}  // namespace tessera::service
