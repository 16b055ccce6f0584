#include "src/front/daemon/node_process.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <csignal>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <spdlog/spdlog.h>

#include "actors/cluster/seat.h"
#include "actors/engine/engine.h"
#include "src/base/files/descriptor.h"
#include "src/base/files/folder.h"
#include "src/base/files/names.h"
#include "src/base/files/private_file.h"
#include "src/base/files/whole_file.h"
#include "src/front/daemon/process_watch.h"
#include "src/front/daemon/supervisor.h"
#include "src/job/engine_steps.h"
#include "src/service/data_format.h"
#include "src/service/http/node_health.h"
#include "src/service/http/server.h"
#include "src/service/processes/costs.h"

namespace tessera::daemon {
namespace {

constexpr std::chrono::milliseconds telling{500};  // between two records of what the process does

// Returns what the process does, as a text for LastWords::doing().
std::string in_words(const NodeWork& work) {
  if (work.shares == 0) return "without tiles";
  return "working on tiles of " + std::to_string(work.shares) + (work.shares == 1 ? " job (" : " jobs (") +
         std::to_string(work.tiles_begun) + " begun and " + std::to_string(work.tiles_stored) + " stored so far, " +
         std::to_string(work.tile_memory_bytes >> 20) + " MiB in memory)";
}

class Health final : public service::http::NodeHealth {
 public:
  Health(const Engine& engine, const service::ServiceOptions& options) : engine_(engine), options_(options) {}

  service::http::NodeFigures figures() const override {
    const NodeWork work = engine_.work();
    const MembershipStatus status = engine_.membership_status();
    service::http::NodeFigures out;
    out.memory_budget_bytes = options_.memory_bytes;
    out.memory_used_bytes = engine_.memory_used();
    out.tile_memory_bytes = work.tile_memory_bytes;
    out.scratch_free_bytes = free_bytes(options_.cluster->scratch);
    out.jobs = work.shares;
    out.tiles_asleep = work.tiles_asleep;
    out.tiles_begun = work.tiles_begun;
    out.tiles_stored = work.tiles_stored;
    out.points = work.weight_begun;
    out.bytes_sent = work.outboxes.bytes;
    out.credit_waits = work.outboxes.waits;
    out.waiting_bytes = work.waiting_bytes;
    out.members = status.others;
    out.member = status.member;
    out.certificate_end_s = static_cast<double>(options_.cluster->certificate_end_s);
    out.lease_seconds = std::chrono::duration<double>(options_.cluster->lease).count();
    out.silent_seconds = static_cast<double>(status.silent_ms) / 1000;
    return out;
  }
  std::optional<std::string> unready() const override {
    const MembershipStatus status = engine_.membership_status();
    if (status.leaves) return "leaves the cluster";
    if (status.member) return std::nullopt;
    return status.trouble;
  }

 private:
  const Engine& engine_;
  const service::ServiceOptions& options_;
};

}  // namespace

Result<FolderLock> take_scratch(const std::filesystem::path& scratch) {
  // The folder must be private. Otherwise the process would read files of other users, and follow their links.
  BOOST_OUTCOME_TRYV(make_private_folder(scratch));
  BOOST_OUTCOME_TRY(lock, FolderLock::take(scratch));
  FolderReader reader(scratch);
  while (const char* name = reader.next()) {
    if (!is_share_scratch_name(name)) continue;
    BOOST_OUTCOME_TRYV(remove_whole(scratch / name));
  }
  if (reader.error()) return io_error(scratch, "cannot be listed", reader.error().value());
  return lock;
}

namespace {

// Calls `what` at once and then each `time`, as long as the timer's context runs.
std::function<void()> again_and_again(boost::asio::steady_timer& timer, std::chrono::steady_clock::duration time,
                                      std::function<void()> what) {
  return [&timer, time, what = std::move(what)] {
    what();
    timer.expires_after(time);
    timer.async_wait([next = again_and_again(timer, time, what)](const boost::system::error_code& error) {
      if (!error) next();
    });
  };
}

}  // namespace

Status serve_node(const service::ServiceOptions& options, service::http::ServerOptions http, LastWords& words,
                  const std::function<void()>& begin_anew) {
  boost::asio::io_context context;
  boost::asio::signal_set signals(context, SIGTERM, SIGINT);
  ClusterOptions cluster = *options.cluster;
  BOOST_OUTCOME_TRYV(make_directories(options.data));
  BOOST_OUTCOME_TRY(identity, service::data_identity(options.data));
  cluster.shared = identity;
  cluster.data = options.data;
  bool again = false, leaves = false;
  cluster.log = [](const std::string& line) { spdlog::info("{}", line); };
  cluster.expelled = [&](const std::string& why, bool may_come_back) {
    boost::asio::post(context, [&, why, may_come_back] {
      spdlog::warn("this node is not a member of the cluster any more: it {}", why);
      again = may_come_back && !leaves;
      if (again) words.ends("was not a member of the cluster any more (it " + why + "), and began anew");
      context.stop();
    });
  };
  BOOST_OUTCOME_TRY(engine, Engine::join(options.threads, options.memory_bytes,
                                         std::make_unique<Seat>(cluster, words.before()), kinds_of_stages()));
  boost::asio::steady_timer until_too_late(context);
  signals.async_wait([&](const boost::system::error_code& error, int signal) {
    if (error) return;
    leaves = true;
    LastWords::end_by(SIGTERM);  // a second signal ends the process at once
    LastWords::end_by(SIGINT);
    spdlog::info("signal {}: this node leaves the cluster as soon as other nodes have its tiles", signal);
    supervisor::stopping();
    engine->depart();
    if (cluster.drain_timeout.count() == 0) return;
    until_too_late.expires_after(cluster.drain_timeout);
    until_too_late.async_wait([&](const boost::system::error_code& error) {
      if (error) return;
      const std::string time = std::to_string(cluster.drain_timeout.count()) + " s";
      spdlog::warn("after {}, other nodes do not have all tiles of this node: it ends all the same, and is lost", time);
      words.ends("was told to end, and did not hand over its tiles within " + time);
      context.stop();
    });
  });
  const Health health(*engine, options);
  std::optional<ProcessWatch> watch(
      std::in_place, [&] { return health.unready(); }, cluster.certificate, cluster.certificate_end_s);
  std::erase_if(http.listeners, [](const service::http::ListenOptions& listener) { return !listener.operations; });
  std::unique_ptr<service::http::Server> server;
  if (!http.listeners.empty()) {
    BOOST_OUTCOME_TRY(started, service::http::Server::start(std::move(http), health));
    server = std::move(started);
  }
  spdlog::info("node {} listens at {}", cluster.node_name, to_string(cluster.advertised));
  supervisor::ready("node of the cluster " + cluster.name);
  boost::asio::steady_timer until_told(context), until_beat(context);
  const std::function<void()> tell = again_and_again(
      until_told, telling, [&] { words.doing((leaves ? "leaving the cluster, " : "") + in_words(engine->work())); });
  tell();
  const auto most = supervisor::watchdog();
  const std::function<void()> beat =
      again_and_again(until_beat, most.value_or(telling) / 3, [] { supervisor::alive(); });
  if (most) beat();
  const auto work = boost::asio::make_work_guard(context);
  context.run();
  watch.reset();   // before the engine, which it uses
  server.reset();  // before begin_anew(): an open socket would stay with the process
  if (again) begin_anew();
  supervisor::stopping();
  engine.reset();
  spdlog::info("the process has ended");
  return success();
}

}  // namespace tessera::daemon
