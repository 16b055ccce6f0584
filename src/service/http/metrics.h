// Figures for Prometheus: about requests over HTTP, and about the service.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "src/service/health_backend.h"
#include "src/service/http/node_health.h"
#include "src/service/http/process_figures.h"
#include "src/service/http/router.h"

namespace tessera::service::http {

class Metrics {
 public:
  explicit Metrics(const std::vector<Route>& routes);
  ~Metrics();

  // `route` is the index in the table of routes, or beyond its end when no route matches.
  void count(std::size_t route, int status, double seconds);
  void count_refused_connection();
  void count_failed_authentication();
  void add_connections(double change);
  // All figures in the text format of Prometheus.
  std::string text(const ServiceFigures& figures);
  std::string text(const NodeFigures& figures);
  // Sets the figures that both kinds of process have. Call this before text().
  void tell(const ProcessFigures& process, bool ready);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera::service::http
