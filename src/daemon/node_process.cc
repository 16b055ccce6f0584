#include "src/daemon/node_process.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <csignal>
#include <memory>
#include <utility>

#include <spdlog/spdlog.h>

#include "actors/cluster/seat.h"
#include "actors/engine/engine.h"
#include "src/daemon/supervisor.h"
#include "src/files/descriptor.h"
#include "src/files/folder.h"
#include "src/files/names.h"
#include "src/files/whole_file.h"
#include "src/service/data_format.h"

namespace tessera {

Result<FolderLock> take_scratch(const std::filesystem::path& scratch) {
  BOOST_OUTCOME_TRYV(make_directories(scratch));
  BOOST_OUTCOME_TRY(lock, FolderLock::take(scratch));
  FolderReader reader(scratch);
  while (const char* name = reader.next()) {
    if (!is_part_scratch_name(name)) continue;
    const auto folder = scratch / name;
    if (const auto failed = remove_tree(folder)) return io_error(folder, "cannot be removed", failed.value());
  }
  return lock;
}

Status serve_node(const ServiceOptions& options, const std::function<void()>& begin_anew) {
  boost::asio::io_context context;
  boost::asio::signal_set signals(context, SIGTERM, SIGINT);
  ClusterOptions cluster = *options.cluster;
  BOOST_OUTCOME_TRYV(make_directories(options.data));
  BOOST_OUTCOME_TRY(identity, data_identity(options.data));
  cluster.shared = identity;
  BOOST_OUTCOME_TRY(lock, take_scratch(cluster.scratch));
  [[maybe_unused]] const FolderLock scratch_is_ours = std::move(lock);
  bool again = false;
  cluster.log = [](const std::string& line) { spdlog::info("{}", line); };
  cluster.expelled = [&](const std::string& why, bool may_come_back) {
    boost::asio::post(context, [&, why, may_come_back] {
      spdlog::warn("this node is no member of the cluster any more: it {}", why);
      again = may_come_back;
      context.stop();
    });
  };
  signals.async_wait([&](const boost::system::error_code& error, int signal) {
    if (error) return;
    spdlog::info("signal {}: leaves the cluster", signal);
    std::signal(SIGTERM, SIG_DFL);  // a second one ends it at once
    std::signal(SIGINT, SIG_DFL);
    context.stop();
  });
  BOOST_OUTCOME_TRY(engine, Engine::join(options.threads, options.memory_bytes, std::make_unique<Seat>(cluster)));
  spdlog::info("node {} listens at {}", cluster.node_name, to_string(cluster.advertised));
  supervisor::ready("node of the cluster " + cluster.name);
  boost::asio::steady_timer timer(context);
  const auto most = supervisor::watchdog();
  std::function<void()> beat = [&] {
    supervisor::alive();
    timer.expires_after(*most / 3);
    timer.async_wait([&](const boost::system::error_code& error) {
      if (!error) beat();
    });
  };
  if (most) beat();
  const auto work = boost::asio::make_work_guard(context);
  context.run();
  if (again) begin_anew();
  supervisor::stopping();
  engine.reset();
  spdlog::info("ended");
  return success();
}

}  // namespace tessera
