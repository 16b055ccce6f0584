#include "src/http/metrics.h"

#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>
#include <prometheus/text_serializer.h>

#include <algorithm>
#include <array>
#include <mutex>

namespace tessera::http {
namespace {

using prometheus::BuildCounter;
using prometheus::BuildGauge;
using prometheus::BuildHistogram;

constexpr std::size_t classes = 6;  // of statuses: 1xx is [1]

}  // namespace

struct Metrics::Impl {
  struct OfRoute {
    std::array<prometheus::Counter*, classes> requests{};
    prometheus::Histogram* seconds = nullptr;
  };

  prometheus::Registry registry;
  std::vector<OfRoute> routes;  // one more than there are: for what fits none
  prometheus::Counter* refused = nullptr;
  prometheus::Counter* unauthorized = nullptr;
  prometheus::Gauge* connections = nullptr;
  prometheus::Family<prometheus::Gauge>* jobs = nullptr;
  prometheus::Family<prometheus::Counter>* ended = nullptr;
  prometheus::Family<prometheus::Counter>* phases = nullptr;
  prometheus::Family<prometheus::Gauge>* nodes = nullptr;
  prometheus::Counter* nodes_lost = nullptr;
  prometheus::Counter* bytes_between = nullptr;
  prometheus::Counter* credit_waits = nullptr;
  prometheus::Gauge* memory_budget = nullptr;
  prometheus::Gauge* memory_used = nullptr;
  prometheus::Gauge* disk_free = nullptr;
  prometheus::Gauge* watchers = nullptr;
  prometheus::Gauge* open_results = nullptr;
  prometheus::Gauge* updates = nullptr;
  prometheus::Counter* points = nullptr;
  std::mutex scraping;

  prometheus::Gauge* gauge(const char* name, const char* help) {
    return &BuildGauge().Name(name).Help(help).Register(registry).Add({});
  }
  prometheus::Counter* counter(const char* name, const char* help) {
    return &BuildCounter().Name(name).Help(help).Register(registry).Add({});
  }
};

namespace {

// The service's counters begin with it, as ours do.
void raise_to(prometheus::Counter& counter, double value) {
  if (value > counter.Value()) counter.Increment(value - counter.Value());
}

}  // namespace

Metrics::Metrics(const std::vector<Route>& routes) : impl_(std::make_unique<Impl>()) {
  Impl& my = *impl_;
  auto& requests = BuildCounter()
                       .Name("tessera_http_requests_total")
                       .Help("Requests answered, by route and class of status")
                       .Register(my.registry);
  auto& seconds = BuildHistogram()
                      .Name("tessera_http_request_seconds")
                      .Help("From the end of a request's header to the begin of its answer, by route")
                      .Register(my.registry);
  const prometheus::Histogram::BucketBoundaries buckets{0.0001, 0.0003, 0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1, 3, 10};
  for (std::size_t at = 0; at <= routes.size(); ++at) {
    const std::string name = at < routes.size() ? routes[at].name : "none";
    Impl::OfRoute of;
    for (std::size_t kind = 2; kind < classes; ++kind)
      of.requests[kind] = &requests.Add({{"route", name}, {"status", std::to_string(kind) + "xx"}});
    of.seconds = &seconds.Add({{"route", name}}, buckets);
    my.routes.push_back(of);
  }
  my.refused = my.counter("tessera_http_connections_refused_total", "Connections beyond the bound");
  my.unauthorized = my.counter("tessera_http_authentications_failed_total", "Requests with a wrong token");
  my.connections = my.gauge("tessera_http_connections", "Open connections");
  my.jobs = &BuildGauge().Name("tessera_jobs").Help("Jobs that wait or run, by state").Register(my.registry);
  my.ended = &BuildCounter().Name("tessera_jobs_ended_total").Help("Jobs that ended, by outcome").Register(my.registry);
  my.phases = &BuildCounter().Name("tessera_phase_seconds_total").Help("Time spent, by phase").Register(my.registry);
  my.nodes = &BuildGauge().Name("tessera_nodes").Help("Nodes that work on jobs, by state").Register(my.registry);
  my.nodes_lost = my.counter("tessera_nodes_lost_total", "Nodes that were lost; not those drained");
  my.bytes_between = my.counter("tessera_node_bytes_total", "Bytes sent from node to node for jobs");
  my.credit_waits =
      my.counter("tessera_credit_waits_total", "Times that what was for another node waited for its window");
  my.points = my.counter("tessera_points_total", "Points triangulated");
  my.memory_budget = my.gauge("tessera_memory_budget_bytes", "Memory that jobs may use together");
  my.memory_used = my.gauge("tessera_memory_used_bytes", "Memory that running jobs may use now");
  my.disk_free = my.gauge("tessera_disk_free_bytes", "Free space where results are stored");
  my.updates = my.gauge("tessera_mailbox_updates", "Messages in the mailboxes of tiles, and on the way there");
  my.watchers = my.gauge("tessera_event_watchers", "Subscriptions to events");
  my.open_results = my.gauge("tessera_open_results", "Results that are kept open for questions");
}

Metrics::~Metrics() = default;

void Metrics::count(std::size_t route, int status, double seconds) {
  Impl::OfRoute& of = impl_->routes[std::min(route, impl_->routes.size() - 1)];
  of.requests[static_cast<std::size_t>(std::clamp(status / 100, 2, 5))]->Increment();
  of.seconds->Observe(seconds);
}

void Metrics::count_refused_connection() { impl_->refused->Increment(); }
void Metrics::count_failed_authentication() { impl_->unauthorized->Increment(); }
void Metrics::add_connections(double change) { impl_->connections->Increment(change); }

std::string Metrics::text(const Backend::Figures& figures) {
  Impl& my = *impl_;
  const std::scoped_lock lock(my.scraping);
  my.jobs->Add({{"state", "accepted"}}).Set(static_cast<double>(figures.accepted));
  my.jobs->Add({{"state", "running"}}).Set(static_cast<double>(figures.running));
  raise_to(my.ended->Add({{"outcome", "successful"}}), static_cast<double>(figures.successful));
  raise_to(my.ended->Add({{"outcome", "failed"}}), static_cast<double>(figures.failed));
  raise_to(my.ended->Add({{"outcome", "dismissed"}}), static_cast<double>(figures.dismissed));
  for (const auto& [phase, seconds] : figures.phase_seconds) raise_to(my.phases->Add({{"phase", phase}}), seconds);
  raise_to(*my.points, static_cast<double>(figures.points));
  for (const auto& [state, count] : figures.nodes) my.nodes->Add({{"state", state}}).Set(static_cast<double>(count));
  raise_to(*my.nodes_lost, static_cast<double>(figures.nodes_lost));
  raise_to(*my.bytes_between, static_cast<double>(figures.bytes_between));
  raise_to(*my.credit_waits, static_cast<double>(figures.credit_waits));
  my.memory_budget->Set(static_cast<double>(figures.memory_budget_bytes));
  my.memory_used->Set(static_cast<double>(figures.memory_used_bytes));
  my.disk_free->Set(static_cast<double>(figures.disk_free_bytes));
  my.updates->Set(static_cast<double>(figures.updates_waiting));
  my.watchers->Set(static_cast<double>(figures.subscribers));
  my.open_results->Set(static_cast<double>(figures.open_results));
  return prometheus::TextSerializer().Serialize(my.registry.Collect());
}

}  // namespace tessera::http
