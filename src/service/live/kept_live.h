// One live result. Changes of callers that wait are put together: one batch makes one version. When a batch is refused,
// its changes are applied one by one, so that one caller's mistake does not touch the others.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <shared_mutex>
#include <stop_token>
#include <string>
#include <vector>

#include "service.pb.h"
#include "src/base/result.h"
#include "src/delaunay/live/live_result.h"
#include "src/delaunay/live/live_version.h"
#include "src/delaunay/update/update.h"
#include "src/result/store/tile_store.h"
#include "src/service/live/version_events.h"

namespace tessera::service {

struct KeptLiveOptions {
  LiveOptions live = {};
  std::uint64_t log_bytes_max = std::uint64_t{64} << 20;  // a longer log is soon stored
  std::function<void()> grown = {};                       // called when the log should be stored
};

// Thread-safe.
class KeptLive {
 public:
  // Errors: those of LiveResult::open().
  static Result<std::unique_ptr<KeptLive>> open(const std::filesystem::path& folder, KeptLiveOptions options);

  // Applies the change, with those of other callers. Errors: those of LiveResult::apply(); interrupted when `stop` was
  // requested before the change was begun.
  Result<proto::PointsChanged> change(const ResultChange& change, EqualToNew equal, const std::stop_token& stop);
  std::shared_ptr<const LiveVersion> current() const { return current_.load(); }
  LiveState state() const;
  // The number of the live version that a version of the stored result is; nothing when that is long ago.
  std::optional<std::uint64_t> number_of(std::uint32_t stored_version) const;
  // Dimension, schema and coordinate system do not change.
  const Manifest& manifest() const { return manifest_; }
  VersionEvents& events() { return *events_; }

  // Whether the log has grown over its bound.
  bool should_store() const;
  // Stores the newest version. Errors: those of LiveResult::checkpoint().
  Status store();

 private:
  struct Waiting;
  KeptLive(std::filesystem::path folder, KeptLiveOptions options, std::unique_ptr<LiveResult> live);
  std::vector<Waiting*> take();
  void run(const std::vector<Waiting*>& batch);
  bool try_together(const std::vector<Waiting*>& batch);
  Result<LiveApplied> apply(const ResultChange& change, EqualToNew equal);
  Status mend();
  void publish();
  void tell(const LiveApplied& applied, std::uint64_t added);

  const std::filesystem::path folder_;
  const KeptLiveOptions options_;
  const Manifest manifest_;
  const std::shared_ptr<VersionEvents> events_;
  std::atomic<std::shared_ptr<const LiveVersion>> current_;
  std::mutex publishing_;

  mutable std::shared_mutex live_mutex_;  // held alone while the result is opened again
  std::unique_ptr<LiveResult> live_;      // null when that has failed
  Error why_not_;                         // then

  mutable std::mutex mutex_;  // of what follows
  std::condition_variable changed_;
  std::deque<Waiting*> waiting_;
  bool busy_ = false;                                       // some caller applies a batch
  mutable std::map<std::uint32_t, std::uint64_t> numbers_;  // by stored version
  std::uint64_t not_before_bytes_ = 0;  // after a failure, the log must grow further before the next attempt
};

}  // namespace tessera::service
