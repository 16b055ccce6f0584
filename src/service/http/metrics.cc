#include "src/service/http/metrics.h"

#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>
#include <prometheus/text_serializer.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <mutex>
#include <string>

#include "src/job/version.h"

namespace tessera::service::http {
namespace {

using prometheus::BuildCounter;
using prometheus::BuildGauge;
using prometheus::BuildHistogram;

constexpr std::size_t classes = 6;  // of statuses; 1xx has index 1

// Raises a counter to a value that is counted elsewhere, from the same start.
void raise_to(prometheus::Counter& counter, double value) {
  if (value > counter.Value()) counter.Increment(value - counter.Value());
}

}  // namespace

struct Metrics::Impl {
  // Made with the first request of its kind, because most kinds never come, and each adds lines to every scrape.
  struct OfRoute {
    std::string name;
    std::array<std::atomic<prometheus::Counter*>, classes> requests{};
    std::atomic<prometheus::Histogram*> seconds{nullptr};
  };

  prometheus::Registry registry;
  std::vector<OfRoute> routes;  // one for each route, and one for requests that match none
  prometheus::Family<prometheus::Counter>* requests = nullptr;
  prometheus::Family<prometheus::Histogram>* seconds = nullptr;
  prometheus::Counter* refused = nullptr;
  prometheus::Counter* unauthorized = nullptr;
  prometheus::Gauge* connections = nullptr;
  std::mutex scraping;

  // A family is registered when it is first used, so a process has only the families of its kind.
  prometheus::Family<prometheus::Gauge>& gauges(const char* name, const char* help) {
    return BuildGauge().Name(name).Help(help).Register(registry);
  }
  prometheus::Family<prometheus::Counter>& counters(const char* name, const char* help) {
    return BuildCounter().Name(name).Help(help).Register(registry);
  }
  prometheus::Gauge* gauge(const char* name, const char* help) { return &gauges(name, help).Add({}); }
  prometheus::Counter* counter(const char* name, const char* help) { return &counters(name, help).Add({}); }
  template <class Number>
  void set(const char* name, const char* help, Number value) {
    gauge(name, help)->Set(static_cast<double>(value));
  }
  template <class Number>
  void raise(const char* name, const char* help, Number value) {
    raise_to(*counter(name, help), static_cast<double>(value));
  }
  prometheus::Counter& requests_of(OfRoute& of, std::size_t kind) {
    prometheus::Counter* there = of.requests[kind];
    if (!there)
      of.requests[kind] = there = &requests->Add({{"route", of.name}, {"status", std::to_string(kind) + "xx"}});
    return *there;
  }
  prometheus::Histogram& seconds_of(OfRoute& of) {
    prometheus::Histogram* there = of.seconds;
    const prometheus::Histogram::BucketBoundaries buckets{0.0001, 0.0003, 0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1, 3, 10};
    if (!there) of.seconds = there = &seconds->Add({{"route", of.name}}, buckets);
    return *there;
  }
  void tell_certificate(double end_s) {
    if (end_s == 0) return;
    set("tessera_certificate_not_after_seconds", "When the cluster's certificate of this process expires, since 1970",
        end_s);
  }
  void tell_memory(std::uint64_t budget, std::uint64_t used) {
    set("tessera_memory_budget_bytes", "Memory that jobs may use together", budget);
    set("tessera_memory_used_bytes", "Memory that running jobs may use now", used);
  }
  void tell_gates(std::uint64_t bytes, std::uint64_t waits) {
    raise("tessera_node_bytes_total", "Bytes sent from node to node for jobs", bytes);
    raise("tessera_credit_waits_total", "Times that what was for another node waited for its window", waits);
  }
  void tell_points(std::uint64_t points) { raise("tessera_points_total", "Points triangulated", points); }
  std::string text() const { return prometheus::TextSerializer().Serialize(registry.Collect()); }
};

Metrics::Metrics(const std::vector<Route>& routes) : impl_(std::make_unique<Impl>()) {
  Impl& my = *impl_;
  my.requests = &BuildCounter()
                     .Name("tessera_http_requests_total")
                     .Help("Requests answered, by route and class of status")
                     .Register(my.registry);
  my.seconds = &BuildHistogram()
                    .Name("tessera_http_request_seconds")
                    .Help("From the end of a request's header to the begin of its answer, by route")
                    .Register(my.registry);
  my.routes = std::vector<Impl::OfRoute>(routes.size() + 1);
  for (std::size_t at = 0; at <= routes.size(); ++at)
    my.routes[at].name = at < routes.size() ? routes[at].name : "none";
  my.refused = my.counter("tessera_http_connections_refused_total", "Connections beyond the bound");
  my.unauthorized = my.counter("tessera_http_authentications_failed_total", "Requests with a wrong token");
  my.connections = my.gauge("tessera_http_connections", "Open connections");
}

Metrics::~Metrics() = default;

void Metrics::count(std::size_t route, int status, double seconds) {
  Impl::OfRoute& of = impl_->routes[std::min(route, impl_->routes.size() - 1)];
  impl_->requests_of(of, static_cast<std::size_t>(std::clamp(status / 100, 2, 5))).Increment();
  impl_->seconds_of(of).Observe(seconds);
}

void Metrics::count_refused_connection() { impl_->refused->Increment(); }
void Metrics::count_failed_authentication() { impl_->unauthorized->Increment(); }
void Metrics::add_connections(double change) { impl_->connections->Increment(change); }

void Metrics::tell(const ProcessFigures& process, bool ready) {
  Impl& my = *impl_;
  const std::scoped_lock lock(my.scraping);
  my.gauges("tessera_build_info", "1, of the version that runs").Add({{"version", version()}}).Set(1);
  my.set("tessera_ready", "1 while /readyz says so", ready ? 1 : 0);
  my.set("process_start_time_seconds", "When the process began, since 1970", process.start_time_s);
  my.raise("process_cpu_seconds_total", "Time on processors", process.cpu_s);
  my.set("process_resident_memory_bytes", "Resident memory", process.resident_bytes);
  my.set("process_virtual_memory_bytes", "Address space in use", process.virtual_bytes);
  my.set("process_open_fds", "Open file descriptors", process.open_files);
  my.set("process_max_fds", "Bound of open file descriptors", process.open_files_max);
  my.set("process_threads", "Threads", process.threads);
}

std::string Metrics::text(const ServiceFigures& figures) {
  Impl& my = *impl_;
  const std::scoped_lock lock(my.scraping);
  auto& jobs = my.gauges("tessera_jobs", "Jobs that wait or run, by state");
  jobs.Add({{"state", "accepted"}}).Set(static_cast<double>(figures.accepted));
  jobs.Add({{"state", "running"}}).Set(static_cast<double>(figures.running));
  auto& ended = my.counters("tessera_jobs_ended_total", "Jobs that ended, by outcome");
  raise_to(ended.Add({{"outcome", "successful"}}), static_cast<double>(figures.successful));
  raise_to(ended.Add({{"outcome", "failed"}}), static_cast<double>(figures.failed));
  raise_to(ended.Add({{"outcome", "dismissed"}}), static_cast<double>(figures.dismissed));
  auto& phases = my.counters("tessera_phase_seconds_total", "Time spent, by phase");
  for (const auto& [phase, seconds] : figures.phase_seconds) raise_to(phases.Add({{"phase", phase}}), seconds);
  my.tell_points(figures.points);
  auto& nodes = my.gauges("tessera_nodes", "Nodes that work on jobs, by state");
  for (const auto& [state, count] : figures.nodes) nodes.Add({{"state", state}}).Set(static_cast<double>(count));
  my.raise("tessera_nodes_lost_total", "Nodes that were lost; not those drained", figures.nodes_lost);
  my.tell_gates(figures.bytes_between, figures.credit_waits);
  my.tell_memory(figures.memory_budget_bytes, figures.memory_used_bytes);
  my.tell_certificate(figures.certificate_end_s);
  my.set("tessera_disk_free_bytes", "Free space where results are stored", figures.disk_free_bytes);
  my.set("tessera_mailbox_updates", "Messages in the mailboxes of tiles, and on the way there",
         figures.updates_waiting);
  my.set("tessera_event_watchers", "Subscriptions to events", figures.subscribers);
  my.set("tessera_open_results", "Results that are kept open for questions", figures.open_results);
  return my.text();
}

std::string Metrics::text(const NodeFigures& figures) {
  Impl& my = *impl_;
  const std::scoped_lock lock(my.scraping);
  my.tell_memory(figures.memory_budget_bytes, figures.memory_used_bytes);
  my.tell_certificate(figures.certificate_end_s);
  my.set("tessera_tile_memory_bytes", "Memory that tiles hold now, mail included", figures.tile_memory_bytes);
  my.set("tessera_scratch_free_bytes", "Free space for tiles that are not in memory", figures.scratch_free_bytes);
  my.set("tessera_node_jobs", "Jobs that this node works on", figures.jobs);
  my.set("tessera_tiles_asleep", "Tiles that are not in memory, but on scratch", figures.tiles_asleep);
  my.raise("tessera_tiles_begun_total", "Tiles triangulated", figures.tiles_begun);
  my.raise("tessera_tiles_stored_total", "Tiles stored", figures.tiles_stored);
  my.tell_points(figures.points);
  my.tell_gates(figures.bytes_sent, figures.credit_waits);
  my.set("tessera_credit_waiting_bytes", "Bytes that wait until another node has room for them", figures.waiting_bytes);
  my.set("tessera_members_reached", "Other processes of the cluster that are connected", figures.members);
  my.set("tessera_member", "1 while the node is a member of its cluster", figures.member ? 1 : 0);
  my.set("tessera_lease_seconds", "Silence after which the node is lost", figures.lease_seconds);
  my.set("tessera_coordinator_silent_seconds", "Since the coordinator was heard", figures.silent_seconds);
  return my.text();
}

}  // namespace tessera::service::http
