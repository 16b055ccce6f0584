// The table of routes and their handlers.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "src/service/http/events.h"
#include "src/service/http/metrics.h"
#include "src/service/http/node_health.h"
#include "src/service/http/router.h"

namespace tessera::service::http {

class Guard;

// Data that must outlive the handlers. The document and the figures are made from the table of routes, so they are set
// after it.
struct Shared {
  EventTexts texts;
  std::string openapi;
  std::unique_ptr<Metrics> metrics;
  Guard* guard = nullptr;
};

// What the listener for supervisors needs.
struct Operations {
  std::string name;  // of what is ready or not
  std::function<std::optional<std::string>()> unready;
  std::function<std::string(Metrics&)> figures;  // as text
};

std::vector<Route> all_routes(Shared& shared, const Backend& backend);
// Only health and figures.
std::vector<Route> node_routes(Shared& shared, const NodeHealth& node);

void add_common_routes(std::vector<Route>& routes, Shared& shared);
void add_session_routes(std::vector<Route>& routes, Shared& shared);
void add_job_routes(std::vector<Route>& routes, Shared& shared);
void add_result_routes(std::vector<Route>& routes);
void add_listing_routes(std::vector<Route>& routes);
void add_question_routes(std::vector<Route>& routes);
void add_map_routes(std::vector<Route>& routes);
void add_live_routes(std::vector<Route>& routes, Shared& shared);
void add_node_routes(std::vector<Route>& routes);
void add_dashboard_routes(std::vector<Route>& routes);
void add_operations_routes(std::vector<Route>& routes, Shared& shared, Operations operations);

// The parameter `limit` of a query. Error usage when it is no number or below 1. At most `max`.
Result<std::uint32_t> limit_of(const Request& request);
// An error of the caller, as a problem with status 400.
Answer bad_request(const Error& error);

}  // namespace tessera::service::http
