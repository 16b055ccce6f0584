// The results that the service keeps in memory, from its start to its end.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "src/service/live/kept_live.h"
#include "src/service/live/live_backend.h"
#include "src/service/results/result_folders.h"

namespace tessera::service {

struct LiveResultsOptions {
  std::vector<std::string> names = {};
  std::uint64_t memory_bytes = 0;  // of all together; each has an equal share
  std::uint64_t log_bytes_max = std::uint64_t{64} << 20;
  unsigned threads = 1;
  std::function<void(const std::string&)> warn = {}, note = {};
};

class LiveResults final : public LiveBackend {
 public:
  // The owner of a result, who may change it; empty when unknown.
  using OwnerOf = std::function<Result<std::string>(const std::string& name)>;
  LiveResults(ResultFolders& folders, LiveResultsOptions options, OwnerOf owner_of)
      : folders_(folders), options_(std::move(options)), owner_of_(std::move(owner_of)) {}
  // Stores what the logs have.
  ~LiveResults() override;

  // Opens the results, and repeats their logs. A result that cannot be opened is not live, and a warning says why.
  // `busy`: the job that will change or replace a result; empty for other results. Such a result is not live either.
  void open(const std::function<std::string(const std::string& name)>& busy);
  // Null for a result that is not live. The object lives as long as this one.
  KeptLive* find(std::string_view name) const;

  Reply<proto::PointsChanged> add(std::string_view name, const PointsBody& points, const Caller& caller) override;
  Reply<proto::PointsChanged> remove(std::string_view name, const PointsBody& ids, const Caller& caller) override;
  Reply<std::unique_ptr<Subscription>> follow(std::string_view name, std::optional<std::uint64_t> last,
                                              OnVersion on_event) override;
  std::optional<proto::LiveInfo> live(std::string_view name) const override;

 private:
  Reply<KeptLive*> find_or_refuse(std::string_view name) const;
  Reply<KeptLive*> find_to_change(std::string_view name, const Caller& caller) const;
  Reply<proto::PointsChanged> apply(KeptLive& live, std::string_view name, const Result<ResultChange>& change,
                                    EqualToNew equal, const Caller& caller);
  void store_what_grows(const std::stop_token& stop);
  void store(const std::string& name, KeptLive& live);
  void warn(const std::string& line) const {
    if (options_.warn) options_.warn(line);
  }

  ResultFolders& folders_;
  const LiveResultsOptions options_;
  const OwnerOf owner_of_;
  // Both are set by open() and do not change afterwards.
  std::map<std::string, std::unique_ptr<KeptLive>, std::less<>> live_;
  std::map<std::string, std::string, std::less<>> refused_;  // why a result that should be live is not
  std::mutex mutex_;
  std::condition_variable_any grown_;
  std::set<std::string> due_;
  std::jthread storer_;
};

}  // namespace tessera::service
