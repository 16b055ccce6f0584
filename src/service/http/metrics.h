// Figures for Prometheus: what is asked over HTTP, and what the service says of itself.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "src/service/http/node_health.h"
#include "src/service/http/process_figures.h"
#include "src/service/http/router.h"
#include "src/service/service.h"

namespace tessera::http {

class Metrics {
 public:
  explicit Metrics(const std::vector<Route>& routes);
  ~Metrics();

  // `route`: its place in the table; beyond its end for what fits none.
  void count(std::size_t route, int status, double seconds);
  void count_refused_connection();
  void count_failed_authentication();
  void add_connections(double change);
  // In the text format of Prometheus.
  std::string text(const Backend::Figures& figures);
  std::string text(const NodeFigures& figures);
  // What both tell, before them.
  void tell(const ProcessFigures& process, bool ready);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera::http
