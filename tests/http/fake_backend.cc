#include "tests/http/fake_backend.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <utility>

namespace tessera::service {
namespace fs = std::filesystem;
namespace {

proto::Problem refused(int status, std::string detail) {
  proto::Problem problem;
  problem.set_status(status);
  problem.set_detail(std::move(detail));
  return problem;
}

}  // namespace

class FakeBackend::Watcher final : public Subscription {
 public:
  Watcher(FakeBackend& owner, std::string id, OnEvent on_event)
      : owner_(owner), id_(std::move(id)), on_event_(std::move(on_event)) {}
  ~Watcher() override {
    const std::scoped_lock lock(owner_.mutex_);
    std::erase(owner_.watchers_, this);
  }
  void hear(const Event& event) {
    if (id_.empty() || event->job_id() == id_) on_event_(event);
  }

 private:
  FakeBackend& owner_;
  const std::string id_;
  const OnEvent on_event_;
};

class FakeBackend::Taken final : public Upload {
 public:
  Taken(FakeBackend& owner, std::string name) : owner_(owner), name_(std::move(name)) {}
  Reply<void> write(std::string_view bytes) override {
    const std::scoped_lock lock(owner_.mutex_);
    owner_.uploads_[name_] += bytes;
    return success();
  }
  Reply<void> finish() override { return success(); }

 private:
  FakeBackend& owner_;
  const std::string name_;
};

FakeBackend::FakeBackend(fs::path folder, std::uint64_t file_bytes) : folder_(std::move(folder)) {
  fs::create_directories(folder_ / "block" / "deep");
  std::ofstream out(folder_ / "block" / "deep" / "tile.vtu", std::ios::binary);
  std::string bytes;
  for (std::uint64_t at = 0; at < file_bytes; ++at) bytes += static_cast<char>(at % 251);
  out << bytes;
  std::ofstream(folder_ / "log.txt") << "one\ntwo\n";
  std::ofstream(folder_ / "page.html") << "<p>how it went</p>";
}

FakeBackend::~FakeBackend() = default;

void FakeBackend::publish(const proto::StatusInfo& status) {
  auto event = std::make_shared<proto::Event>();
  event->set_id(events_.size() + 1);
  event->set_kind("status");
  event->set_job_id(status.job_id());
  *event->mutable_status() = status;
  events_.push_back(event);
  for (Watcher* watcher : watchers_) watcher->hear(event);
}

void FakeBackend::set_state(const std::string& id, const std::string& state) {
  const std::scoped_lock lock(mutex_);
  for (proto::StatusInfo& job : jobs_) {
    if (job.job_id() != id) continue;
    job.set_status(state);
    job.set_resumable(state == "dismissed" || state == "failed");
    if (state == "successful" && job.process_id() == "triangulate") job.set_triangulation("block");
    if (state == "failed") *job.mutable_problem() = refused(422, "block.las: its points span no volume");
    publish(job);
  }
}

void FakeBackend::tell(int count) {
  const std::scoped_lock lock(mutex_);
  proto::StatusInfo status;
  status.set_job_id("j0");
  status.set_message(std::string(200, 'x'));
  for (int at = 0; at < count; ++at) publish(status);
}

Reply<Submitted> FakeBackend::submit(const proto::Inputs& inputs, const Caller& caller, std::string_view key) {
  if (inputs.has_triangulate() && inputs.triangulate().inputs_size() == 0)
    return refused(400, "inputs: must name at least one file");
  const std::scoped_lock lock(mutex_);
  const std::string text = inputs.SerializeAsString();
  if (const auto known = keys_.find(key); !key.empty() && known != keys_.end()) {
    if (known->second.first != text) return refused(422, "Idempotency-Key: was used with other inputs");
    for (const proto::StatusInfo& job : jobs_)
      if (job.job_id() == known->second.second) return Submitted{job, false};
  }
  proto::StatusInfo job;
  job.set_job_id("j" + std::to_string(jobs_.size() + 1));
  job.set_id(job.job_id());
  job.set_type("process");
  job.set_status("accepted");
  job.set_submitter(caller.name);
  job.set_created("2030-01-01T00:00:00Z");
  job.set_process_id(inputs.GetDescriptor()->FindFieldByNumber(inputs.of_case())->name());
  jobs_.push_back(job);
  if (!key.empty()) keys_.emplace(key, std::pair{text, job.job_id()});
  publish(job);
  return Submitted{job, true};
}

Reply<proto::Estimate> FakeBackend::estimate(const proto::Inputs& inputs, const Caller& caller) {
  {
    std::unique_lock lock(mutex_);
    const auto& names = inputs.triangulate().inputs();
    if (std::find(names.begin(), names.end(), "until.gone") != names.end()) return give_up(lock, caller.stop);
    wait_while_held(lock);
  }
  proto::Estimate estimate;
  estimate.set_points(9'007'199'254'740'993);  // more than a double holds
  estimate.set_accepted(true);
  return estimate;
}

Reply<std::string> FakeBackend::info(const proto::InfoInputs&, const Caller&) { return std::string(R"({"points":7})"); }

Reply<proto::JobList> FakeBackend::list(const JobQuery& query) {
  const std::scoped_lock lock(mutex_);
  proto::JobList list;
  bool begun = query.after.empty();
  for (const proto::StatusInfo& job : jobs_) {
    const bool wanted =
        query.states.empty() || std::find(query.states.begin(), query.states.end(), job.status()) != query.states.end();
    if (begun && wanted && list.jobs_size() < static_cast<int>(query.limit)) *list.add_jobs() = job;
    if (job.job_id() == query.after) begun = true;
  }
  list.set_number_matched(jobs_.size());
  return list;
}

Reply<proto::StatusInfo> FakeBackend::status(std::string_view id) {
  const std::scoped_lock lock(mutex_);
  for (const proto::StatusInfo& job : jobs_)
    if (job.job_id() == id) return job;
  proto::Problem problem = refused(404, "there is no job '" + std::string(id) + "'");
  problem.set_type("http://www.opengis.net/def/exceptions/ogcapi-processes-1/1.0/no-such-job");
  return problem;
}

Reply<proto::StatusInfo> FakeBackend::dismiss(std::string_view id, const Caller&) {
  set_state(std::string(id), "dismissed");
  return status(id);
}

Reply<proto::StatusInfo> FakeBackend::resume(std::string_view id, const Caller&) {
  set_state(std::string(id), "accepted");
  return status(id);
}

Reply<ServedFile> FakeBackend::open(const fs::path& path, const char* type, std::string etag) const {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return refused(404, "there is no such file");
  return ServedFile{fd, fs::file_size(path), type, std::move(etag)};
}

Reply<ServedFile> FakeBackend::log(std::string_view id) {
  if (auto found = status(id); !found) return found.error();
  return open(folder_ / "log.txt", "text/plain", "");
}

Reply<ServedFile> FakeBackend::report(std::string_view id) {
  if (auto found = status(id); !found) return found.error();
  return open(folder_ / "page.html", "text/html", "");
}

Reply<proto::JobTiles> FakeBackend::tiles(std::string_view id, bool with_layout) {
  if (auto found = status(id); !found) return found.error();
  proto::JobTiles tiles;
  tiles.set_job_id(std::string(id));
  tiles.set_stages("wtsd");
  if (with_layout) tiles.mutable_layout()->set_dimension(2);
  return tiles;
}

Reply<std::string> FakeBackend::outcome(std::string_view) { return std::string(R"({"proved":true})"); }

Reply<std::unique_ptr<Subscription>> FakeBackend::subscribe(std::string_view id, std::uint64_t last, OnEvent on_event) {
  if (before_subscribe) before_subscribe();
  auto watcher = std::make_unique<Watcher>(*this, std::string(id), std::move(on_event));
  const std::scoped_lock lock(mutex_);
  if (last > 0)
    for (const Event& event : events_)
      if (event->id() > last) watcher->hear(event);
  watchers_.push_back(watcher.get());
  return std::unique_ptr<Subscription>(std::move(watcher));
}

void FakeBackend::hold(bool held) {
  const std::scoped_lock lock(mutex_);
  holding_ = held;
  held_changed_.notify_all();
}

void FakeBackend::wait_while_held(std::unique_lock<std::mutex>& lock) {
  ++held_;
  held_changed_.notify_all();
  held_changed_.wait(lock, [&] { return !holding_; });
  --held_;
}

void FakeBackend::wait_for_held(int count) {
  std::unique_lock lock(mutex_);
  held_changed_.wait(lock, [&] { return held_ >= count; });
}

Reply<proto::TriangulationList> FakeBackend::list(std::uint32_t, std::string_view after) {
  {
    std::unique_lock lock(mutex_);
    wait_while_held(lock);
  }
  proto::TriangulationList list;
  if (after.empty()) *list.add_triangulations() = info("block").value();
  return list;
}

Reply<proto::TriangulationInfo> FakeBackend::info(std::string_view name) {
  if (name != "block") return refused(404, "there is no triangulation '" + std::string(name) + "'");
  proto::TriangulationInfo info;
  info.set_name("block");
  info.set_dimension(3);
  info.set_vertices(12);
  return info;
}

Reply<std::string> FakeBackend::versions(std::string_view name) {
  if (name != "block") return refused(404, "there is no such triangulation");
  return std::string(R"({"result":"block","version":1,"keep_versions":1,"versions":[]})") + "\n";
}

Reply<ServedFile> FakeBackend::file(std::string_view name, std::string_view path) {
  if (name != "block" || path != "deep/tile.vtu") return refused(404, "there is no such file");
  return open(folder_ / "block" / "deep" / "tile.vtu", "application/xml", "\"xxh3-0123\"");
}

Reply<void> FakeBackend::remove(std::string_view name, const Caller&) {
  if (name != "block") return refused(404, "there is no such triangulation");
  return refused(409, "a job works on it");
}

Reply<void> FakeBackend::remove_export(std::string_view name, std::string_view file, const Caller&) {
  if (name != "block" || file != "mesh.ply") return refused(404, "there is no such export");
  return success();
}

Reply<std::unique_ptr<Upload>> FakeBackend::upload(std::string_view folder, std::string_view file, std::uint64_t offset,
                                                   const Caller&) {
  std::string name = std::string(folder) + "/" + std::string(file);
  const std::scoped_lock lock(mutex_);
  std::string& there = uploads_[name];
  if (offset != there.size()) return refused(409, "Upload-Offset: is not where the file ends");
  return std::unique_ptr<Upload>(std::make_unique<Taken>(*this, std::move(name)));
}

Reply<std::string> FakeBackend::identity(std::string_view name) {
  if (name != "block") return refused(404, "there is no such triangulation");
  return std::string("block-1");
}

void FakeBackend::wait_for_asked(int count) {
  std::unique_lock lock(mutex_);
  held_changed_.wait(lock, [&] { return asked_ >= count; });
}

void FakeBackend::wait_for_given_up(int count) {
  std::unique_lock lock(mutex_);
  held_changed_.wait(lock, [&] { return given_up_ >= count; });
}

Reply<std::uint64_t> FakeBackend::uploaded(std::string_view folder, std::string_view file) {
  const std::scoped_lock lock(mutex_);
  const auto found = uploads_.find(std::string(folder) + "/" + std::string(file));
  if (found == uploads_.end()) return refused(404, "there is no such upload");
  return found->second.size();
}

Reply<void> FakeBackend::remove_upload(std::string_view folder, std::string_view file, const Caller&) {
  const std::scoped_lock lock(mutex_);
  if (uploads_.erase(std::string(folder) + "/" + std::string(file)) == 0)
    return refused(404, "there is no such upload");
  return boost::outcome_v2::success();
}

Reply<proto::NodeList> FakeBackend::list() {
  proto::NodeList list;
  for (const char* name : {"a", "b"}) {
    proto::NodeInfo& node = *list.add_nodes();
    node.set_name(name);
    node.set_state("free");
    node.set_coordinator(list.nodes_size() == 1);
  }
  return list;
}

Reply<proto::NodeInfo> FakeBackend::drain(std::string_view node, const Caller&) {
  if (node == "a") return refused(409, "node 'a': it is the only one");
  if (node != "b") return refused(404, "there is no node '" + std::string(node) + "'");
  proto::NodeInfo drained;
  drained.set_name("b");
  drained.set_state("draining");
  return drained;
}

Reply<proto::PointsChanged> FakeBackend::change_points(std::string_view name, const PointsBody& body, bool add) {
  if (name != "block") return refused(409, "triangulation '" + std::string(name) + "' is not live");
  if (body.bytes.starts_with("refuse")) return refused(400, "the body: is refused");
  const std::scoped_lock lock(mutex_);
  proto::VersionMade made;
  made.set_version(++version_);
  made.set_added(add ? 1 : 0);
  made.set_removed(add && !body.replace ? 0 : 1);
  for (const double bound : {0.0, 0.5, 1.0, 2.0, 2.5, 3.0})
    (made.changed_size() ? made.mutable_changed(0) : made.add_changed())->add_bounds(bound);
  versions_->tell(made);
  proto::PointsChanged told;
  told.set_version(version_);
  told.set_first_id(add ? 100 + version_ : 0);
  told.set_added(made.added());
  told.set_removed(made.removed());
  return told;
}

Reply<proto::PointsChanged> FakeBackend::add(std::string_view name, const PointsBody& points, const Caller&) {
  return change_points(name, points, true);
}

Reply<proto::PointsChanged> FakeBackend::remove(std::string_view name, const PointsBody& ids, const Caller&) {
  return change_points(name, ids, false);
}

Reply<std::unique_ptr<Subscription>> FakeBackend::follow(std::string_view name, std::optional<std::uint64_t> last,
                                                         OnVersion on_event) {
  if (name != "block") return refused(404, "there is no triangulation '" + std::string(name) + "'");
  return versions_->follow(last, std::move(on_event));
}

std::optional<proto::LiveInfo> FakeBackend::live(std::string_view name) const {
  if (name != "block") return std::nullopt;
  const std::scoped_lock lock(mutex_);
  proto::LiveInfo info;
  info.set_version(version_);
  info.set_vertices(12);
  return info;
}

ServiceFigures FakeBackend::figures() const {
  const std::scoped_lock lock(mutex_);
  ServiceFigures figures;
  figures.accepted = jobs_.size();
  figures.phase_seconds = {{"triangulating", 1.5}};
  figures.subscribers = watchers_.size();
  figures.nodes = {{"free", 2}};
  figures.nodes_lost = 3;
  figures.bytes_between = 4096;
  figures.credit_waits = 5;
  return figures;
}

std::optional<std::string> FakeBackend::unready() const { return std::nullopt; }
std::optional<std::string> FakeBackend::lost() const { return std::nullopt; }

}  // namespace tessera::service
