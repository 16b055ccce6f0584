// A service without an engine: jobs are accepted and stand still until a test says otherwise, results are files of a
// folder made for it.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "src/service/backend.h"
#include "src/service/live/version_events.h"

namespace tessera::service {

class FakeBackend final : public ProcessesBackend,
                          public JobsBackend,
                          public ResultsBackend,
                          public QuestionsBackend,
                          public InputsBackend,
                          public NodesBackend,
                          public HealthBackend,
                          public LiveBackend {
 public:
  // Makes a result "block" below `folder`, with a file of `file_bytes` bytes i % 251.
  FakeBackend(std::filesystem::path folder, std::uint64_t file_bytes);
  ~FakeBackend() override;
  Backend backend() { return {*this, *this, *this, *this, *this, *this, *this, *this}; }

  // The job is in that state from now on; watchers hear of it.
  void set_state(const std::string& id, const std::string& state);
  // From now on lists of results and estimates are not answered, until they are again.
  void hold(bool held);
  // Until so many are not answered.
  void wait_for_held(int count);
  // Watchers of all jobs hear `count` events.
  void tell(int count);
  // Until so many stars of vertex 13 are being looked for, or estimates of "until.gone" made.
  void wait_for_asked(int count);
  // Profiles have so many bytes at least.
  std::size_t profile_bytes = 0;
  // Called by subscribe() before it does anything.
  std::function<void()> before_subscribe;

  Reply<Submitted> submit(const proto::Inputs& inputs, const Caller& caller, std::string_view idempotency_key) override;
  Reply<proto::Estimate> estimate(const proto::Inputs& inputs, const Caller& caller) override;
  Reply<std::string> info(const proto::InfoInputs& inputs, const Caller& caller) override;
  Reply<proto::JobList> list(const JobQuery& query) override;
  Reply<proto::StatusInfo> status(std::string_view id) override;
  Reply<proto::StatusInfo> dismiss(std::string_view id, const Caller& caller) override;
  Reply<proto::StatusInfo> resume(std::string_view id, const Caller& caller) override;
  Reply<ServedFile> log(std::string_view id) override;
  Reply<ServedFile> report(std::string_view id) override;
  Reply<proto::JobTiles> tiles(std::string_view id, bool with_layout) override;
  Reply<std::string> outcome(std::string_view id) override;
  Reply<std::unique_ptr<Subscription>> subscribe(std::string_view id, std::uint64_t last, OnEvent on_event) override;
  Reply<proto::TriangulationList> list(std::uint32_t limit, std::string_view after) override;
  Reply<proto::TriangulationInfo> info(std::string_view name) override;
  Reply<std::string> versions(std::string_view name) override;
  Reply<ServedFile> file(std::string_view name, std::string_view path) override;
  Reply<void> remove(std::string_view name, const Caller& caller) override;
  Reply<proto::ExportList> exports(std::string_view name, std::uint32_t limit, std::string_view after) override;
  Reply<proto::InputList> list(std::string_view folder, std::uint32_t limit, std::string_view after,
                               const Caller& caller) override;
  Reply<void> remove_export(std::string_view name, std::string_view file, const Caller& caller) override;
  Reply<std::string> identity(std::string_view name) override;
  // At once; but the star of vertex 13, and an estimate of "until.gone", only when nobody waits for it any more.
  Reply<QuestionAnswer> ask(const Question& question) override;
  Reply<std::vector<FeatureCollection>> collections() override;
  Reply<FeatureCollection> collection(std::string_view id) override;
  Reply<std::array<double, 4>> map_extent(std::string_view name) override;
  // Until so many such stars were given up.
  void wait_for_given_up(int count);
  Reply<std::unique_ptr<Upload>> upload(std::string_view folder, std::string_view file, std::uint64_t offset,
                                        const Caller& caller) override;
  Reply<std::uint64_t> uploaded(std::string_view folder, std::string_view file) override;
  Reply<void> remove_upload(std::string_view folder, std::string_view file, const Caller& caller) override;
  Reply<proto::NodeList> list() override;
  Reply<proto::NodeInfo> drain(std::string_view node, const Caller& caller) override;
  // The result "block" is live. A body that begins with "refuse" is refused; any other adds or removes a point, or
  // does both to replace one.
  Reply<proto::PointsChanged> add(std::string_view name, const PointsBody& points, const Caller& caller) override;
  Reply<proto::PointsChanged> remove(std::string_view name, const PointsBody& ids, const Caller& caller) override;
  Reply<std::unique_ptr<Subscription>> follow(std::string_view name, std::optional<std::uint64_t> last,
                                              OnVersion on_event) override;
  std::optional<proto::LiveInfo> live(std::string_view name) const override;
  ServiceFigures figures() const override;
  std::optional<std::string> unready() const override;
  std::optional<std::string> lost() const override;

 private:
  // REQUIRES: `lock` is that of mutex_. Until nobody waits.
  void wait_while_held(std::unique_lock<std::mutex>& lock);
  proto::Problem give_up(std::unique_lock<std::mutex>& lock, const std::stop_token& stop);
  Reply<proto::PointsChanged> change_points(std::string_view name, const PointsBody& body, bool add);
  class Watcher;
  class Taken;
  using Event = std::shared_ptr<const proto::Event>;
  void publish(const proto::StatusInfo& status);
  Reply<ServedFile> open(const std::filesystem::path& path, const char* type, std::string etag) const;

  const std::filesystem::path folder_;
  mutable std::mutex mutex_;
  std::condition_variable held_changed_;  // with mutex_
  bool holding_ = false;
  int held_ = 0;
  int given_up_ = 0, asked_ = 0;
  std::vector<proto::StatusInfo> jobs_;                                           // j1, j2, ...
  std::map<std::string, std::pair<std::string, std::string>, std::less<>> keys_;  // key -> inputs, id
  std::vector<Event> events_;
  std::vector<Watcher*> watchers_;
  std::shared_ptr<VersionEvents> versions_ = std::make_shared<VersionEvents>(0);
  std::uint64_t version_ = 0;
  std::map<std::string, std::string, std::less<>> uploads_;
};

}  // namespace tessera::service
