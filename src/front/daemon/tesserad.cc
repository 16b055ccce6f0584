// The daemon `tesserad`: jobs over HTTP. It runs until SIGTERM or SIGINT. Then requests drain, jobs stop where they can
// be resumed, and the next start resumes them. SIGHUP reads tokens and certificate again. A process that only works for
// a cluster hands over its tiles before it ends (node_process.h).
#include <malloc.h>
#include <sys/stat.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>
#include <memory>
#include <new>
#include <optional>
#include <string>

#include <spdlog/spdlog.h>

#include "src/base/files/open_files.h"
#include "src/base/option.h"
#include "src/base/printable.h"
#include "src/front/apps/help.h"
#include "src/front/apps/words.h"
#include "src/front/daemon/daemon_log.h"
#include "src/front/daemon/daemon_options.h"
#include "src/front/daemon/data_rights.h"
#include "src/front/daemon/health.h"
#include "src/front/daemon/last_words.h"
#include "src/front/daemon/node_process.h"
#include "src/front/daemon/process_watch.h"
#include "src/front/daemon/supervisor.h"
#include "src/input/bytes/objects.h"
#include "src/input/remote/remote_objects.h"
#include "src/input/snapshot/gadget_hdf5.h"
#include "src/job/version.h"
#include "src/service/http/server.h"
#include "src/service/service.h"

namespace tessera::daemon {
namespace {

constexpr std::chrono::seconds drain_time{10};

// Reports an error on stderr, with `json` as a line of the log, and returns the exit status.
int fail(const Error& error, bool json = false) {
  const std::string sentence = render(error.where, apps::flag_name);
  if (json) {
    if (!spdlog::get(daemon_log_name)) start_daemon_log(true, false);
    spdlog::error("{}", sentence);
  } else {
    std::fprintf(stderr, "tesserad: %s\n", printable(sentence).c_str());
  }
  return static_cast<int>(error.code);
}

// Returns the address of the API for users: "http://127.0.0.1:7070/".
std::string address_of(const service::http::ServerOptions& options, std::uint16_t port) {
  if (!options.public_url.empty())
    return options.public_url.back() == '/' ? options.public_url : options.public_url + "/";
  const std::string& host = options.listeners.front().address;
  return std::string(options.certificate.empty() ? "http" : "https") + "://" +
         (host.find(':') == std::string::npos ? host : "[" + host + "]") + ":" + std::to_string(port) + "/";
}

// Runs the daemon until a signal ends it. Signals are caught as soon as the object exists, and handled in run() and
// pause().
class Life {
 public:
  void run(service::Service& service, service::http::Server& server) {
    service_ = &service;
    server_ = &server;
    wait_for_signal();
    if (const auto most = supervisor::watchdog()) beat(*most / 3);
    context_.run();
  }

  // Waits so long, or until a signal to end comes. Returns whether no such signal came. REQUIRES: run() was not called.
  bool pause(std::chrono::milliseconds time) {
    bool goes_on = true;
    const std::function<void()> listen = [&] {
      signals_.async_wait([&](const boost::system::error_code& error, int signal) {
        if (error) return;
        if (signal == SIGHUP) return listen();
        goes_on = false;
        context_.stop();
      });
    };
    listen();
    timer_.expires_after(time);
    timer_.async_wait([&](const boost::system::error_code&) { context_.stop(); });
    context_.run();
    signals_.cancel();
    timer_.cancel();
    context_.restart();
    context_.poll();  // runs the handlers of the cancelled operations
    context_.restart();
    return goes_on;
  }

 private:
  void wait_for_signal() {
    signals_.async_wait([this](const boost::system::error_code& error, int signal) {
      if (error) return;
      if (signal != SIGHUP) {
        spdlog::info("signal {}: the daemon ends; its jobs stop where they can be resumed", signal);
        LastWords::end_by(SIGTERM);  // a second signal ends the process at once
        LastWords::end_by(SIGINT);
        context_.stop();
        return;
      }
      supervisor::reloading();
      if (const Status reloaded = server_->reload(); !reloaded) {
        spdlog::error("{}; the tokens, certificate and key that were read before stay in use",
                      render(reloaded.error().where, apps::flag_name));
      } else {
        spdlog::info("tokens, certificate and key were read again");
      }
      supervisor::ready("serving");
      wait_for_signal();
    });
  }

  // Tells the supervisor again and again that the daemon is alive. Each time it asks the service for something that
  // needs the service's lock, so a daemon that hangs is not reported alive.
  void beat(std::chrono::microseconds pause) {
    (void)service_->health().figures();
    supervisor::alive();
    timer_.expires_after(pause);
    timer_.async_wait([this, pause](const boost::system::error_code& error) {
      if (!error) beat(pause);
    });
  }

  service::Service* service_ = nullptr;
  service::http::Server* server_ = nullptr;
  boost::asio::io_context context_;
  boost::asio::signal_set signals_{context_, SIGTERM, SIGINT, SIGHUP};
  boost::asio::steady_timer timer_{context_};
};

// Waits for a data folder that another process holds, until that process ends or has been silent for long enough.
class Turn {
 public:
  Turn(Life& life, std::chrono::milliseconds lease) : life_(life), until_(Clock::now() + lease * 5 / 4) {}

  bool wait(const Error& why) {
    constexpr std::chrono::seconds between_looks{1};
    if (!told_) spdlog::info("{}; this daemon waits until that process ends, or is not heard of any more", why.where);
    told_ = true;
    if (Clock::now() >= until_) return false;
    given_up_ = !life_.pause(between_looks);
    return !given_up_;
  }
  // Returns whether a signal ended the waiting.
  bool given_up() const { return given_up_; }

 private:
  using Clock = std::chrono::steady_clock;
  Life& life_;
  const Clock::time_point until_;
  bool told_ = false, given_up_ = false;
};

// Ends the process at once, because another process has taken over the data folder. An orderly end would write to the
// folder.
[[noreturn]] void end_without_data_folder(const Error& why, LastWords* words) {
  spdlog::critical("{}; the daemon ends with status {}", why.where, static_cast<int>(why.code));
  spdlog::default_logger()->flush();
  if (words) words->ends(Status(why));
  std::_Exit(static_cast<int>(why.code));
}

Status serve_api(DaemonOptions options, LastWords* words) {
  Life life;
  Turn turn(life, options.service.data_lease);
  options.service.locked = [&turn](const Error& why) { return turn.wait(why); };
  options.service.lost = [words](const Error& why) { end_without_data_folder(why, words); };
  options.service.log = [](const std::string& line) { spdlog::warn("{}", render(line, apps::flag_name)); };
  options.service.note = [](const std::string& line) { spdlog::info("{}", render(line, apps::flag_name)); };
  const std::optional<ClusterOptions> cluster = options.service.cluster;
  if (!options.hdf5) snapshot::refuse_hdf5();
  if (options.remote) {
    set_objects(remote::remote_objects(*std::move(options.remote)));
    spdlog::info("inputs may also be read by addresses below those that remote-prefix lists");
  }
  auto opened = service::Service::open(std::move(options.service));
  if (!opened && turn.given_up()) return success();
  BOOST_OUTCOME_TRY(service, std::move(opened));
  BOOST_OUTCOME_TRY(server, service::http::Server::start(options.http, service->backend()));
  const std::string address = address_of(options.http, server->ports().front());
  // The token is printed once, on stdout, for the user who starts the daemon in a terminal. It must not reach a log: a
  // service manager logs what it reads from a pipe. Browsers do not send what stands behind '#', so the token is in no
  // log of a proxy either.
  if (const std::string token = server->token(); !token.empty() && (options.print_token || ::isatty(STDOUT_FILENO))) {
    std::printf("%s#token=%s\n", address.c_str(), token.c_str());
    std::fflush(stdout);
  }
  spdlog::info("tesserad {} serves at {}; the tokens are in {}", version(), address, options.http.tokens.string());
  if (options.http.insecure) spdlog::warn("without TLS, anybody on the network can read tokens and data");
  supervisor::ready("serving at " + address);
  std::optional<ProcessWatch> watch(
      std::in_place, [&] { return service->health().unready(); },
      cluster ? cluster->certificate : std::filesystem::path(), cluster ? cluster->certificate_end_s : 0);
  life.run(*service, *server);
  watch.reset();
  supervisor::stopping();
  if (!server->drain(drain_time)) spdlog::warn("some requests did not end in time, and were cut off");
  server.reset();
  service.reset();
  spdlog::info("the process has ended");
  return success();
}

Status serve(DaemonOptions options, const std::function<void()>& begin_anew) {
  start_daemon_log(options.json_log, options.http.insecure);
  BOOST_OUTCOME_TRY(who, who_else_may_enter(options.service.data));
  if (who) spdlog::warn("{}", *who);
  if (!options.service.cluster) return serve_api(std::move(options), nullptr);
  ClusterOptions& cluster = *options.service.cluster;
  BOOST_OUTCOME_TRY(lock, take_scratch(cluster.scratch));
  [[maybe_unused]] const FolderLock scratch_is_ours = std::move(lock);
  BOOST_OUTCOME_TRY(words, LastWords::keep(cluster.scratch));
  if (!words->before().empty()) spdlog::warn("the process before this one {}", words->before());
  cluster.log = [](const std::string& line) { spdlog::info("{}", line); };
  cluster.expelled = [](const std::string& why, bool) { spdlog::warn("this process takes no more work: it {}", why); };
  const bool is_node_alone = !cluster.coordinator;
  Status served = is_node_alone ? serve_node(options.service, options.http, *words, begin_anew)
                                : serve_api(std::move(options), words.get());
  words->ends(served);
  return served;
}

int tesserad_main(int argc, char** argv) {
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  // Jobs, results and uploads are for this user alone, whatever the inherited umask is.
  ::umask(077);
  // Each thread's malloc pool keeps memory that no budget shows, so there are few pools. The command does the same.
  mallopt(M_ARENA_MAX, 4);
  raise_open_files_limit();  // the limit of a shell is too small for connections and jobs together
  CLI::App app("Exact Delaunay triangulations as a service: jobs over HTTP.", "tesserad");
  app.set_version_flag("--version", std::string("tesserad ") + version());
  DaemonSettings settings;
  add_daemon_options(app, settings);
  std::string metrics = "127.0.0.1:7071";
  CLI::App* health =
      app.add_subcommand("health", "Asks a daemon whether it can take jobs; the exit status is 0 if it can");
  health->add_option("--metrics", metrics, "the daemon's address of health checks and metrics")->type_name("ADDRESS");
  app.footer("Examples:\n  tesserad --data /srv/tessera --inputs /srv/lidar\n  tesserad health");
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help) {
    return app.exit(help);
  } catch (const CLI::ParseError& wrong) {
    return fail(error(Errc::usage, apps::wrong_arguments(app, "tesserad", wrong) + "; see 'tesserad --help'"),
                settings.top.text("log") == "json");
  }
  if (health->parsed()) {
    const Status ready = check_health(metrics);
    return ready ? 0 : fail(ready.error());
  }
  auto options = read_daemon_options(settings, [](const char* name) { return std::getenv(name); });
  if (!options) return fail(options.error(), settings.top.text("log") == "json");
  const bool json = options.value().json_log;
  // Starts the same program with the same options in this process, so that nothing of the lost node stays.
  const auto begin_anew = [argv] {
    ::execv("/proc/self/exe", argv);
    std::fprintf(stderr, "tesserad: the process cannot start itself again\n");
    std::_Exit(static_cast<int>(Errc::internal));
  };
  const Status served = serve(std::move(options).value(), begin_anew);
  return served ? 0 : fail(served.error(), json);
}

}  // namespace
}  // namespace tessera::daemon

int main(int argc, char** argv) {
  try {
    return tessera::daemon::tesserad_main(argc, argv);
  } catch (const std::bad_alloc&) {
    return tessera::daemon::fail(tessera::error(tessera::Errc::memory, "the system has no more memory to give"));
  } catch (const std::exception& e) {
    return tessera::daemon::fail(tessera::error(tessera::Errc::internal, std::string("unexpected: ") + e.what()));
  }
}
