#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "src/base/json/json_text.h"
#include "src/service/http/handlers.h"
#include "src/service/http/processes.h"
#include "src/service/http/ranges.h"
#include "src/service/json.h"
#include "src/service/processes/table.h"

namespace tessera::service::http {
namespace {

constexpr std::size_t key_length_max = 255;

Answer unknown_process(const std::string& name) {
  return problem(404, "there is no process '" + name + "'", 0,
                 "http://www.opengis.net/def/exceptions/ogcapi-processes-1/1.0/no-such-process");
}

std::optional<Answer> wrong_type(const Request& request) {
  const std::string type = media_type(request.header("content-type"));
  if (type == json || type == protobuf_type) return std::nullopt;
  return problem(415, "the body must be application/json or application/x-protobuf, and Content-Type say which");
}

std::vector<std::string> list_of(std::string_view text) {
  std::vector<std::string> words;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(','), text.size());
    if (end > 0) words.emplace_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return words;
}

Answer execute(const Call& call) {
  const Process* process = find_process(call.arguments[0]);
  if (!process) return unknown_process(call.arguments[0]);
  if (auto refused = wrong_type(call.request)) return std::move(*refused);
  const Result<proto::Inputs> inputs = read_inputs(*process, call.request);
  if (!inputs) return bad_request(inputs.error());
  const bool asks_for_job = call.request.header("prefer").find("respond-async") != std::string_view::npos;
  if (process->waits && !asks_for_job) {
    Reply<std::string> told = call.context.backend->processes.info(inputs.value().info(), call.request.caller);
    return told ? json_answer(200, std::move(told.value())) : problem(told.error());
  }
  const std::string_view key = call.request.header("idempotency-key");
  if (key.size() > key_length_max) return problem(400, "Idempotency-Key: has more than 255 characters", 2);
  Reply<Submitted> submitted = call.context.backend->processes.submit(inputs.value(), call.request.caller, key);
  if (!submitted) return problem(submitted.error());
  proto::StatusInfo& status = submitted.value().status;
  call.context.links.add(call.request, status);
  // A repeated submission gets the existing job, with the same answer as the first.
  Answer answer = message_answer(call.request, 201, status);
  answer.headers.emplace_back("Location", call.context.links.to(call.request, job_path(status.job_id())));
  if (asks_for_job) answer.headers.emplace_back("Preference-Applied", "respond-async");
  return answer;
}

Answer estimate(const Call& call) {
  const Process* process = find_process(call.arguments[0]);
  if (!process || !process->estimated()) return unknown_process(call.arguments[0]);
  if (auto refused = wrong_type(call.request)) return std::move(*refused);
  const Result<proto::Inputs> inputs = read_inputs(*process, call.request);
  if (!inputs) return bad_request(inputs.error());
  const Reply<proto::Estimate> told = call.context.backend->processes.estimate(inputs.value(), call.request.caller);
  return told ? message_answer(call.request, 200, told.value()) : problem(told.error());
}

Answer jobs(const Call& call) {
  const Target& target = call.request.target;
  const Result<std::uint32_t> limit = limit_of(call.request);
  if (!limit) return bad_request(limit.error());
  JobQuery query;
  query.limit = limit.value();
  query.states = list_of(target.parameter("status").value_or(""));
  query.processes = list_of(target.parameter("processID").value_or(""));
  query.after = target.parameter("after").value_or("");
  constexpr std::string_view states[] = {"accepted", "running", "successful", "failed", "dismissed"};
  for (const std::string& state : query.states)
    if (std::find(std::begin(states), std::end(states), state) == std::end(states))
      return problem(400, "status: must be accepted, running, successful, failed or dismissed", 2);
  Reply<proto::JobList> found = call.context.backend->jobs.list(query);
  if (!found) return problem(found.error());
  proto::JobList& list = found.value();
  for (proto::StatusInfo& job : *list.mutable_jobs()) call.context.links.add(call.request, job);
  list.clear_links();
  *list.add_links() = call.context.links.link(call.request, "/v1/jobs", "self", json);
  // A full page may be the last one: then the next page is empty.
  if (list.jobs_size() > 0 && static_cast<std::uint32_t>(list.jobs_size()) == query.limit) {
    std::string next = "/v1/jobs?limit=" + std::to_string(query.limit);
    for (const char* name : {"status", "processID"})
      if (const auto value = target.parameter(name)) next += std::string("&") + name + "=" + encode_segment(*value);
    next += "&after=" + encode_segment(list.jobs(list.jobs_size() - 1).job_id());
    *list.add_links() = call.context.links.link(call.request, next, "next", json);
  }
  return message_answer(call.request, 200, list);
}

Answer status_answer(const Call& call, Reply<proto::StatusInfo> status) {
  if (!status) return problem(status.error());
  call.context.links.add(call.request, status.value());
  return message_answer(call.request, 200, status.value());
}

Answer job(const Call& call) { return status_answer(call, call.context.backend->jobs.status(call.arguments[0])); }

Answer dismiss(const Call& call) {
  return status_answer(call, call.context.backend->jobs.dismiss(call.arguments[0], call.request.caller));
}

Answer resume(const Call& call) {
  return status_answer(call, call.context.backend->jobs.resume(call.arguments[0], call.request.caller));
}

// Files by reference; output of a command in place.
Answer results(const Call& call) {
  const Reply<proto::StatusInfo> found = call.context.backend->jobs.status(call.arguments[0]);
  if (!found) return problem(found.error());
  const proto::StatusInfo& status = found.value();
  if (status.status() == "failed" && status.has_problem()) return problem(status.problem());
  if (status.status() == "dismissed") return problem(410, "the job was dismissed: it has no results");
  if (status.status() != "successful")
    return problem(404, "the job is " + status.status() + ": its results are not there yet", 0,
                   std::string(result_not_ready));
  nlohmann::ordered_json told = nlohmann::ordered_json::object();
  if (!status.triangulation().empty()) {
    const std::string path = triangulation_path(status.triangulation());
    told["triangulation"] = {{"href", call.context.links.to(call.request, path)}, {"type", json}};
  }
  if (status.process_id() != "triangulate") {
    const Reply<std::string> outcome = call.context.backend->jobs.outcome(call.arguments[0]);
    if (!outcome) return problem(outcome.error());
    const auto value = parse_ordered_json(outcome.value());
    told["outcome"] = {{"value", value.is_discarded() ? nlohmann::ordered_json(outcome.value()) : value}};
  }
  return json_answer(200, json_text(told));
}

Answer tiles(const Call& call) {
  const auto layout = call.request.target.parameter("layout").value_or("false");
  if (layout != "true" && layout != "false") return problem(400, "layout: must be true or false", 2);
  const Reply<proto::JobTiles> found = call.context.backend->jobs.tiles(call.arguments[0], layout == "true");
  return found ? message_answer(call.request, 200, found.value()) : problem(found.error());
}

Answer log(const Call& call) {
  const Reply<ServedFile> file = call.context.backend->jobs.log(call.arguments[0]);
  return file ? file_answer(call.request, file.value()) : problem(file.error());
}

Answer report(const Call& call) {
  const Reply<ServedFile> file = call.context.backend->jobs.report(call.arguments[0]);
  return file ? file_answer(call.request, file.value()) : problem(file.error());
}

// `id` is empty for all jobs.
Answer events(const Call& call, Shared& shared, const std::string& id) {
  const std::string_view last_id = call.request.header("last-event-id");
  std::uint64_t last = 0;
  if (!last_id.empty()) {
    // A number that no daemon has given: from now on, as without a number.
    if (last_id.size() <= 19 && last_id.find_first_not_of("0123456789") == std::string_view::npos)
      last = std::stoull(std::string(last_id));
    else
      return problem(400, "Last-Event-ID: is not the number of an event", 2);
  }
  auto queue = std::make_shared<EventQueue>(shared.texts, id, EventQueue::Limits{});
  std::string told;  // the state
  const auto tell_now = [&]() -> std::optional<proto::Problem> {
    Reply<proto::StatusInfo> status = call.context.backend->jobs.status(id);
    if (!status) return status.error();
    if (last != 0 || status.value().status() == told) return std::nullopt;
    told = status.value().status();
    call.context.links.add(call.request, status.value());
    auto now = std::make_shared<proto::Event>();
    now->set_job_id(id);
    now->set_kind("status");
    *now->mutable_status() = std::move(status).value();
    queue->add(now);
    return std::nullopt;
  };
  // First the current state; otherwise a watcher would wait for the next change, or for ever.
  if (!id.empty())
    if (const auto refused = tell_now()) return problem(*refused);
  // The queue outlives the subscription that it holds.
  Reply<std::unique_ptr<Subscription>> subscription = call.context.backend->jobs.subscribe(
      id, last, [to = queue.get()](const std::shared_ptr<const proto::Event>& event) { to->add(event); });
  if (!subscription) return problem(subscription.error());
  // Again, because the watcher missed a change between the two calls, which may have been the last.
  if (!id.empty())
    if (const auto refused = tell_now()) return problem(*refused);
  queue->keep(std::move(subscription.value()));
  Answer answer;
  answer.headers = {{"Content-Type", "text/event-stream"}, {"X-Accel-Buffering", "no"}, {"Cache-Control", "no-store"}};
  answer.events = std::move(queue);
  answer.close = true;
  return answer;
}

}  // namespace

void add_job_routes(std::vector<Route>& routes, Shared& shared) {
  const Response status{200, json, "StatusInfo", "The job"};
  const std::vector<Parameter> paging{{"limit", "integer", "How many entries a page has at most"},
                                      {"after", "string", "The last entry of the page before"}};
  std::vector<Parameter> filters = paging;
  filters.push_back({"status", "string", "Only jobs in these states, separated by commas"});
  filters.push_back({"processID", "string", "Only jobs of these processes, separated by commas"});
  const Response stream{200, "text/event-stream", "", "The events, as they come"};
  routes.push_back({"POST",
                    "/v1/processes/{process}/execution",
                    Role::submit,
                    "execute",
                    "Submit a job, which runs a process",
                    {{201, json, "StatusInfo", "The job; the header Location has its address"},
                     {200, json, "Document", "The answer of a process that needs no job"}},
                    execute,
                    {},
                    "JsonExecute"});
  routes.push_back({"POST",
                    "/v1/processes/{process}/estimate",
                    Role::submit,
                    "estimate",
                    "Estimate the time, memory and disk of a job",
                    {{200, json, "Estimate", "The estimate; or the reason why the job would be refused"}},
                    estimate,
                    {},
                    "JsonExecute"});
  routes.push_back({"GET",
                    "/v1/jobs",
                    Role::read,
                    "listJobs",
                    "The jobs, in pages",
                    {{200, json, "JobList", "The jobs"}},
                    jobs,
                    filters});
  routes.push_back({"GET", "/v1/jobs/{job}", Role::read, "getJob", "The status of a job", {status}, job});
  routes.push_back({"DELETE",
                    "/v1/jobs/{job}",
                    Role::submit,
                    "dismissJob",
                    "Dismiss a job that waits or runs, or remove one that has ended; its result stays",
                    {status},
                    dismiss});
  routes.push_back({"GET",
                    "/v1/jobs/{job}/results",
                    Role::read,
                    "getResults",
                    "The results of a job",
                    {{200, json, "Results", "Links to the results"}},
                    results});
  routes.push_back({"GET",
                    "/v1/jobs/{job}/events",
                    Role::read,
                    "watchJob",
                    "The events of a job: its states, progress and log",
                    {stream},
                    [&shared](const Call& call) { return events(call, shared, call.arguments[0]); }});
  routes.push_back(
      {"GET", "/v1/events", Role::read, "watchAll", "The events of all jobs", {stream}, [&shared](const Call& call) {
         return events(call, shared, {});
       }});
  routes.push_back({"GET",
                    "/v1/jobs/{job}/tiles",
                    Role::read,
                    "getTiles",
                    "The progress of each tile of a job of the process triangulate",
                    {{200, json, "JobTiles", "The state of each tile, as a letter"}},
                    tiles,
                    {{"layout", "boolean", "Also the boxes of the tiles"}}});
  routes.push_back({"GET",
                    "/v1/jobs/{job}/log",
                    Role::read,
                    "getLog",
                    "The log of a job",
                    {{200, "text/plain", "", "The log"}, {206, "text/plain", "", "A part of it"}},
                    log});
  routes.push_back({"GET",
                    "/v1/jobs/{job}/report",
                    Role::read,
                    "getReport",
                    "The report of a job, as a page",
                    {{200, "text/html", "", "The report"}, {206, "text/html", "", "A part of it"}},
                    report});
  routes.push_back({"POST",
                    "/v1/jobs/{job}/resume",
                    Role::submit,
                    "resumeJob",
                    "Resume a job that has failed or was dismissed",
                    {status},
                    resume});
  // Answers that the service has in memory.
  for (Route& route : routes)
    for (const char* name : {"listJobs", "getJob", "watchJob", "watchAll"})
      if (route.name == name) route.runs = Runs::at_once;
}

}  // namespace tessera::service::http
