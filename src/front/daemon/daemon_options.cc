#include "src/front/daemon/daemon_options.h"

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "src/base/files/data_names.h"
#include "src/base/files/names.h"
#include "src/cluster/cluster_options.h"
#include "src/front/daemon/add_option.h"
#include "src/front/daemon/cluster_settings.h"
#include "src/input/remote/permits.h"
#include "src/job/arguments.h"
#include "src/job/machine.h"

namespace tessera::daemon {
namespace {

constexpr std::uint64_t data_lease_min_s = 2, data_lease_max_s = 3600;

Result<std::string> as_text(const std::string& text) { return text; }

Result<std::uint64_t> count_or(const std::string& text, const char* none) {
  if (text == none) return std::uint64_t{0};
  return parse_count(text);
}

Result<std::uint32_t> at_least_one(const std::string& text) {
  BOOST_OUTCOME_TRY(number, parse_integer(text, 1, 100'000'000));
  return static_cast<std::uint32_t>(number);
}

Result<std::uint64_t> bytes_or_unlimited(const std::string& text) {
  return text == "unlimited" ? Result<std::uint64_t>(std::uint64_t{0}) : parse_memory(text);
}

Status read_limits(const apps::Settings& settings, service::ServiceLimits& limits) {
  BOOST_OUTCOME_TRY(queued, settings.get("queued", at_least_one));
  BOOST_OUTCOME_TRY(jobs, settings.get("jobs", at_least_one));
  BOOST_OUTCOME_TRY(points, settings.get("points", [](const std::string& t) { return count_or(t, "unlimited"); }));
  BOOST_OUTCOME_TRY(disk, settings.get("disk", bytes_or_unlimited));
  BOOST_OUTCOME_TRY(ended, settings.get("ended", at_least_one));
  BOOST_OUTCOME_TRY(reserve, settings.get("reserve", parse_memory));
  BOOST_OUTCOME_TRY(uploads, settings.get("uploads", bytes_or_unlimited));
  limits.ended_of_a_caller = ended.value_or(limits.ended_of_a_caller);
  limits.reserve_bytes = reserve.value_or(limits.reserve_bytes);
  limits.upload_bytes = uploads.value_or(0);
  limits.queued = queued.value_or(limits.queued);
  limits.jobs_of_a_caller = jobs.value_or(limits.jobs_of_a_caller);
  limits.points = points.value_or(0);
  limits.disk_bytes = disk.value_or(0);
  return success();
}

Status read_live(const DaemonSettings& settings, service::ServiceOptions& service) {
  BOOST_OUTCOME_TRY(names, settings.top.get("live", parse_names));
  BOOST_OUTCOME_TRY(memory, settings.top.get("live-memory", or_auto(parse_memory, 0)));
  BOOST_OUTCOME_TRY(log, settings.limits.get("live-log", parse_memory));
  service.live = names.value_or(std::vector<std::string>{});
  service.live_memory_bytes = memory.value_or(0);
  service.live_log_bytes = log.value_or(service.live_log_bytes);
  return success();
}

// What inputs may be besides files of the usual formats.
Status read_inputs(const apps::Settings& top, const std::function<const char*(const char*)>& get_environment,
                   DaemonOptions& out) {
  BOOST_OUTCOME_TRY(hdf5, top.on("hdf5"));
  out.hdf5 = hdf5;
  BOOST_OUTCOME_TRY(prefixes, top.get("remote-prefix", parse_names));
  BOOST_OUTCOME_TRY(anonymous, top.on("s3-anonymous"));
  if (!prefixes || prefixes->empty()) {
    if (anonymous) return error(Errc::usage, "s3-anonymous: no address may be read; remote-prefix names some");
    return success();
  }
  auto permits = remote::Permits::parse(*prefixes);
  if (!permits) return error(permits.error().code, "remote-prefix: " + permits.error().where);
  remote::RemoteOptions& remote = out.remote.emplace();
  remote.permits = std::make_shared<const remote::Permits>(std::move(permits).value());
  remote.s3.anonymous = anonymous;
  remote.ca_file = remote::ca_file_of(get_environment);
  remote.folder = out.service.data;
  return success();
}

}  // namespace

Result<service::http::ListenOptions> parse_listen_address(std::string_view text) {
  const auto wrong = [&] {
    return error(Errc::usage, "'" + std::string(text) + "' is no address like 127.0.0.1:7070 or [::1]:7070");
  };
  service::http::ListenOptions out;
  const bool port_alone = text.find(':') == std::string_view::npos;
  const auto parsed = parse_host_port(port_alone ? out.address + ":" + std::string(text) : std::string(text));
  if (!parsed) return wrong();
  out.address = parsed.value().host;
  out.port = parsed.value().port;
  return out;
}

Result<std::uint64_t> parse_duration(std::string_view text) {
  if (text == "forever") return std::uint64_t{0};
  std::uint64_t unit = 1;
  std::string_view digits = text;
  if (!text.empty()) {
    const std::size_t at = std::string_view("smhd").find(text.back());
    constexpr std::uint64_t seconds[] = {1, 60, 3600, 86'400};
    if (at != std::string_view::npos) {
      unit = seconds[at];
      digits.remove_suffix(1);
    }
  }
  const auto number = parse_integer(digits, 1, 1'000'000);
  if (!number) return error(Errc::usage, "'" + std::string(text) + "' is no time like 12h, 30d or forever");
  return static_cast<std::uint64_t>(number.value()) * unit;
}

void add_daemon_options(CLI::App& app, DaemonSettings& settings) {
  apps::Settings& top = settings.top;
  add_option(app, top, "config", "FILE", "read options from this TOML file (see config/tesserad.toml)");
  add_option(app, top, "data", "DIR", "the folder of jobs, results and tokens; it is made if it is missing");
  add_option(app, top, "listen", "ADDRESS", "the address of the API; default: 127.0.0.1:7070");
  add_option(app, top, "metrics", "ADDRESS",
             "the address of health checks and metrics; default: 127.0.0.1:7071; none: these are not served");
  add_option(app, top, "inputs", "DIR,...",
             "the folders whose files, also in subfolders, jobs may read; default: none");
  add_list(app, top, "remote-prefix", "URL,...",
           "beginnings of addresses (https://, http://, s3://) below which jobs may read inputs; may be given several "
           "times; default: none");
  add_switch(app, top, "s3-anonymous", "do not sign requests for inputs s3://");
  add_switch(app, top, "hdf5", "read inputs in HDF5, whose library was not made for files of strangers");
  add_option(app, top, "memory", "BYTES", "memory for all running jobs together; default: 70 % of what is available");
  add_option(app, top, "threads", "N", "threads for all running jobs together; default: all processors");
  add_option(app, top, "jobs", "N", "how many jobs run at once; default: 1");
  add_list(
      app, top, "live", "NAME,...",
      "the results that are kept in memory, so that clients can add and remove points; may be given several times");
  add_option(app, top, "live-memory", "BYTES",
             "memory for all live results together, a part of the daemon's memory; default: half of it");
  add_switch(app, top, "uploads", "let clients upload input files");
  add_option(app, top, "retention", "TIME", "how long ended jobs are remembered, for example 30d; default: forever");
  add_option(app, top, "tls-certificate", "FILE", "the TLS certificate with its chain, as a PEM file");
  add_option(app, top, "tls-key", "FILE", "the key of the TLS certificate, as a PEM file");
  add_option(app, top, "public-url", "URL", "the address that users type, when a proxy stands in front of the daemon");
  add_option(app, top, "hosts", "NAME,...", "names of this machine that requests may use, besides localhost");
  add_switch(app, top, "insecure", "listen beyond the loopback without TLS; every line of the log says so");
  add_option(app, top, "log", "text|json", "the format of the log; default: text");
  add_switch(app, top, "print-token",
             "print the address with a token also when stdout is not a terminal; whatever reads stdout may then keep "
             "the token");
  add_cluster_options(app, top);
  // These have only variables and keys, because users hardly type them.
  for (const char* key : {"queued", "jobs", "ended", "points", "disk", "reserve", "uploads", "data-lease", "live-log"})
    settings.limits.declare(key);
}

Result<DaemonOptions> read_daemon_options(DaemonSettings& settings,
                                          const std::function<const char*(const char*)>& get_environment) {
  apps::Settings& top = settings.top;
  top.load_environment(get_environment);
  settings.limits.load_environment(get_environment);
  if (const auto file = top.text("config")) {
    BOOST_OUTCOME_TRYV(apps::load_settings_file(*file, {&top, &settings.limits}));
  }

  DaemonOptions out;
  BOOST_OUTCOME_TRYV(read_limits(settings.limits, out.service.limits));
  BOOST_OUTCOME_TRY(data_lease, settings.limits.get("data-lease", parse_duration));
  if (data_lease && (*data_lease < data_lease_min_s || *data_lease > data_lease_max_s))
    return error(Errc::usage, "limits.data-lease: must be from 2s to 1h");
  if (data_lease) out.service.data_lease = std::chrono::seconds(*data_lease);
  BOOST_OUTCOME_TRY(data, top.get("data", as_text));
  if (!data || data->empty()) return error(Errc::usage, "--data DIR is needed: the folder of jobs and results");
  BOOST_OUTCOME_TRY(inputs, top.get("inputs", parse_names));
  BOOST_OUTCOME_TRY(memory, top.get("memory", or_auto(parse_memory, 0)));
  BOOST_OUTCOME_TRY(threads, top.get("threads", or_auto(at_least_one, 0)));
  BOOST_OUTCOME_TRY(jobs, top.get("jobs", at_least_one));
  BOOST_OUTCOME_TRY(uploads, top.on("uploads"));
  BOOST_OUTCOME_TRY(retention, top.get("retention", parse_duration));
  BOOST_OUTCOME_TRY(listen, top.get("listen", parse_listen_address));
  BOOST_OUTCOME_TRY(metrics,
                    top.get("metrics", [](const std::string& t) -> Result<std::optional<service::http::ListenOptions>> {
                      if (t == "none") return std::optional<service::http::ListenOptions>{};
                      BOOST_OUTCOME_TRY(address, parse_listen_address(t));
                      return std::optional(address);
                    }));
  BOOST_OUTCOME_TRY(certificate, top.get("tls-certificate", as_text));
  BOOST_OUTCOME_TRY(key, top.get("tls-key", as_text));
  BOOST_OUTCOME_TRY(public_url, top.get("public-url", as_text));
  BOOST_OUTCOME_TRY(hosts, top.get("hosts", parse_names));
  BOOST_OUTCOME_TRY(insecure, top.on("insecure"));
  BOOST_OUTCOME_TRY(log, top.get("log", as_text));
  if (log && *log != "text" && *log != "json")
    return error(Errc::usage, "log: '" + *log + "' is neither text nor json");
  service::ServiceOptions& service = out.service;
  service.data = *data;
  for (std::string& root : inputs.value_or(std::vector<std::string>{})) service.roots.emplace_back(std::move(root));
  service.memory_bytes = memory.value_or(0) > 0 ? *memory : default_memory();
  service.threads = threads.value_or(0) > 0 ? *threads : usable_processors();
  service.limits.running = jobs.value_or(1);
  service.uploads = uploads;
  service.retention_s = retention.value_or(0);
  BOOST_OUTCOME_TRYV(read_live(settings, service));
  BOOST_OUTCOME_TRYV(read_inputs(top, get_environment, out));
  BOOST_OUTCOME_TRY(cluster, read_cluster_options(top, service.data));
  service.cluster = std::move(cluster);

  service::http::ServerOptions& server = out.http;
  server.listeners.push_back(listen.value_or(service::http::ListenOptions{.address = "127.0.0.1", .port = 7070}));
  auto operations = metrics.value_or(service::http::ListenOptions{.address = "127.0.0.1", .port = 7071});
  if (operations) {
    operations->operations = true;
    server.listeners.push_back(*operations);
  }
  server.certificate = certificate.value_or("");
  server.key = key.value_or("");
  server.tokens = tokens_file(service.data);
  server.sessions = sessions_file(service.data);
  server.hosts = hosts.value_or(std::vector<std::string>{});
  server.public_url = public_url.value_or("");
  server.insecure = insecure;
  BOOST_OUTCOME_TRY(print_token, top.on("print-token"));
  out.print_token = print_token;
  out.json_log = log.value_or("text") == "json";
  return out;
}

}  // namespace tessera::daemon
