#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "src/base/json/json_text.h"
#include "src/service/http/absolute.h"
#include "src/service/http/handlers.h"
#include "src/service/http/openapi.h"
#include "src/service/http/processes.h"
#include "src/service/http/tokens.h"
#include "src/service/processes/table.h"

namespace tessera::service::http {
namespace {

using nlohmann::ordered_json;

struct Entry {
  const char* path;
  const char* rel;
  const char* type;
  const char* title;
};
constexpr Entry entries[] = {
    {"/v1", "self", json, "This page"},
    {"/v1/api", "service-desc", "application/vnd.oai.openapi+json;version=3.0", "The API"},
    {"/v1/conformance", "http://www.opengis.net/def/rel/ogc/1.0/conformance", json,
     "The standards that the service conforms to"},
    {"/v1/processes", "http://www.opengis.net/def/rel/ogc/1.0/processes", json, "The processes: the kinds of jobs"},
    {"/v1/jobs", "http://www.opengis.net/def/rel/ogc/1.0/job-list", json, "The jobs"},
    {"/v1/triangulations", "triangulations", json, "The results"},
    {"/v1/inputs", "inputs", json, "The files that jobs may read"},
    {"/v1/collections", "data", json, "The results as features on maps"},
    {"/v1/nodes", "nodes", json, "The nodes that work on the jobs"},
    {"/v1/caller", "caller", json, "The name and role of your token"},
    {"/v1/events", "events", "text/event-stream", "Events of all jobs, as they come"},
    {"/ui/", "alternate", "text/html", "The dashboard"}};

Answer landing(const Call& call) {
  if (prefers(call.request, "text/html")) {
    Answer answer;
    answer.headers = {{"Content-Type", "text/html; charset=utf-8"}, {"Vary", "Accept"}};
    answer.body = "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>Tessera</title><h1>Tessera</h1><ul>";
    for (const Entry& entry : entries)
      answer.body +=
          "<li><a href=\"" + call.context.links.to(call.request, entry.path) + "\">" + entry.title + "</a></li>";
    answer.body += "</ul></html>\n";
    return answer;
  }
  ordered_json page{{"title", "Tessera"},
                    {"description", "Exact Delaunay triangulations of large point clouds, as jobs."},
                    {"links", ordered_json::array()}};
  for (const Entry& entry : entries)
    page["links"].push_back({{"href", absolute(call.context.links, call.request, entry.path)},
                             {"rel", entry.rel},
                             {"type", entry.type},
                             {"title", entry.title}});
  Answer answer = json_answer(200, json_text(page));
  answer.headers.emplace_back("Vary", "Accept");
  return answer;
}

std::string conformance_text() {
  std::vector<std::string> all;
  const auto add = [&](const char* standard, std::initializer_list<const char*> names) {
    for (const char* name : names)
      all.push_back(std::string("http://www.opengis.net/spec/") + standard + "/1.0/conf/" + name);
  };
  add("ogcapi-processes-1", {"core", "json", "oas30", "ogc-process-description", "job-list", "dismiss"});
  add("ogcapi-common-1", {"core", "json", "oas30"});
  add("ogcapi-features-1", {"core", "geojson", "oas30"});
  add("ogcapi-features-2", {"crs"});
  add("ogcapi-tiles-1", {"core", "tileset", "tilesets-list", "png"});
  return json_text(ordered_json{{"conformsTo", all}});
}

Answer conformance(const Call&) {
  // The text is constant, and writing it would take a third of the time of the whole answer.
  static const std::string text = conformance_text();
  return json_answer(200, text);
}

Answer process_list(const Call& call) {
  ordered_json list{{"processes", ordered_json::array()}, {"links", ordered_json::array()}};
  for (const Process* process : all_processes())
    list["processes"].push_back(process_summary(*process, call.context.links, call.request));
  list["links"].push_back(
      {{"href", call.context.links.to(call.request, "/v1/processes")}, {"rel", "self"}, {"type", json}});
  return json_answer(200, json_text(list));
}

Answer process(const Call& call) {
  const Process* found = find_process(call.arguments[0]);
  if (!found)
    return problem(404, "there is no process '" + call.arguments[0] + "'", 0,
                   "http://www.opengis.net/def/exceptions/ogcapi-processes-1/1.0/no-such-process");
  return json_answer(200, json_text(process_description(*found, call.context.links, call.request)));
}

Answer caller(const Call& call) {
  proto::CallerInfo told;
  told.set_name(call.request.caller.name);
  told.set_role(std::string(word_of(call.request.caller.role)));
  return message_answer(call.request, 200, told);
}

Answer text_answer(int status, std::string text, const char* type = "text/plain; charset=utf-8") {
  Answer answer;
  answer.status = status;
  answer.headers = {{"Content-Type", type}, {"Cache-Control", "no-store"}};
  answer.body = std::move(text);
  return answer;
}

Answer ready(const Call& call, const Operations& operations) {
  const std::optional<std::string> why = operations.unready();
  if (!call.request.target.parameter("verbose")) return text_answer(why ? 503 : 200, why ? "not ready\n" : "ready\n");
  const std::string& name = operations.name;
  std::string told = why ? "[-] " + name + ": " + *why + "\nnot ready\n" : "[+] " + name + "\n[+] http\nready\n";
  return text_answer(why ? 503 : 200, std::move(told));
}

}  // namespace

void add_common_routes(std::vector<Route>& routes, Shared& shared) {
  const std::size_t first = routes.size();
  const Response page{200, json, "LandingPage", "Links to everything"};
  routes.push_back(
      {"GET", "/", Role::read, "getRoot", "Links to everything; a browser is sent to the dashboard", {page}, landing});
  routes.push_back({"GET", "/v1", Role::read, "getLandingPage", "Links to everything", {page}, landing});
  routes.push_back({"GET",
                    "/v1/api",
                    Role::read,
                    "getApi",
                    "This description of the API",
                    {{200, "application/vnd.oai.openapi+json;version=3.0", "", "The description, in OpenAPI 3.0"}},
                    [&shared](const Call&) {
                      Answer answer = json_answer(200, shared.openapi);
                      answer.headers.back().second = "application/vnd.oai.openapi+json;version=3.0";
                      return answer;
                    }});
  routes.push_back({"GET",
                    "/v1/conformance",
                    Role::read,
                    "getConformance",
                    "The standards that the service conforms to",
                    {{200, json, "Conformance", "The URIs of their conformance classes"}},
                    conformance});
  routes.push_back({"GET",
                    "/v1/processes",
                    Role::read,
                    "listProcesses",
                    "The processes: the kinds of jobs",
                    {{200, json, "ProcessList", "The processes"}},
                    process_list});
  routes.push_back({"GET",
                    "/v1/processes/{process}",
                    Role::read,
                    "getProcess",
                    "A process, with its inputs and outputs",
                    {{200, json, "Process", "The process"}},
                    process});
  routes.push_back({"GET",
                    "/v1/caller",
                    Role::read,
                    "getCaller",
                    "The name and role of the caller's token",
                    {{200, json, "CallerInfo", "The name and the role"}},
                    caller});
  for (std::size_t at = first; at < routes.size(); ++at) routes[at].runs = Runs::at_once;
}

void add_operations_routes(std::vector<Route>& routes, Shared& shared, Operations operations) {
  Route live{"GET",
             "/livez",
             Role::none,
             "live",
             "Tells whether the service answers",
             {{200, "text/plain", "", "The service answers"}},
             [](const Call&) { return text_answer(200, "live\n"); }};
  Route is_ready{
      "GET",
      "/readyz",
      Role::none,
      "ready",
      "Tells whether the service can take jobs",
      {{200, "text/plain", "", "It can"}, {503, "text/plain", "", "It cannot; with verbose, the reason"}},
      [operations](const Call& call) { return ready(call, operations); },
      {{"verbose", "string", "Any value: also tell what was checked, and the reason when the service is not ready"}}};
  Route metrics{"GET",
                "/metrics",
                Role::none,
                "metrics",
                "Metrics for Prometheus",
                {{200, "text/plain", "", "The metrics, in the text format of Prometheus"}},
                [&shared, operations](const Call&) {
                  shared.metrics->tell(process_figures(), !operations.unready());
                  return text_answer(200, operations.figures(*shared.metrics),
                                     "text/plain; version=0.0.4; charset=utf-8");
                }};
  for (Route* route : {&live, &is_ready, &metrics}) {
    route->place = Place::operations;
    route->runs = route == &live ? Runs::at_once : Runs::health;
    routes.push_back(std::move(*route));
  }
}

std::vector<Route> all_routes(Shared& shared, const Backend& backend) {
  std::vector<Route> routes;
  add_common_routes(routes, shared);
  add_session_routes(routes, shared);
  add_job_routes(routes, shared);
  add_result_routes(routes);
  add_listing_routes(routes);
  add_question_routes(routes);
  add_map_routes(routes);
  add_live_routes(routes, shared);
  add_node_routes(routes);
  add_dashboard_routes(routes);
  add_operations_routes(routes, shared,
                        {"service", [&backend] { return backend.health.unready(); },
                         [&backend](Metrics& metrics) { return metrics.text(backend.health.figures()); }});
  for (Route& route : routes)
    if (route.method != "GET" && route.method != "HEAD" && !route.upload && route.runs == Runs::disk)
      route.runs = Runs::changes;
  shared.openapi = openapi_document(routes, "..");
  shared.metrics = std::make_unique<Metrics>(routes);
  return routes;
}

std::vector<Route> node_routes(Shared& shared, const NodeHealth& node) {
  std::vector<Route> routes;
  add_operations_routes(
      routes, shared,
      {"node", [&node] { return node.unready(); }, [&node](Metrics& metrics) { return metrics.text(node.figures()); }});
  shared.metrics = std::make_unique<Metrics>(routes);
  return routes;
}

}  // namespace tessera::service::http
