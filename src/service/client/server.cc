#include "src/service/client/server.h"

#include <algorithm>

#include <cstdint>

#include <nlohmann/json.hpp>
#include <utility>

#include "src/base/json/json_text.h"
#include "src/base/random_token.h"
#include "src/service/client/event_stream.h"
#include "src/service/client/messages.h"
#include "src/service/client/patience.h"

namespace tessera::client {
namespace {

constexpr std::chrono::seconds silence_of_events{45};  // the server sends something every 15 s
// The problem of `info` for large inputs.
constexpr const char* takes_a_job = "urn:tessera:needs-a-job";

}  // namespace

bool Server::is_json(const HttpHead& head) {
  const auto& type = head.header("content-type");
  return type.starts_with("application/json") || type.starts_with("application/problem+json");
}

Errc Server::code_of(int status, int cause) {
  if (cause >= static_cast<int>(Errc::usage) && cause <= static_cast<int>(Errc::internal))
    return static_cast<Errc>(cause);
  if (status == 429 || status >= 500) return Errc::io;
  return Errc::usage;
}

std::string new_idempotency_key() { return random_token() + random_token(); }

Server::Server(ServerOptions options, Connection connection, Connection watching)
    : options_(std::move(options)), connection_(std::move(connection)), watching_(std::move(watching)) {}

Result<Server> Server::make(ServerOptions options) {
  if (options.token.empty()) options.token = options.address.token;
  const auto printable = [](unsigned char c) { return c > 0x20 && c < 0x7f; };
  if (!std::all_of(options.token.begin(), options.token.end(), printable))
    return error(Errc::usage, "the token has a space, or another character that no token can have");
  BOOST_OUTCOME_TRY(connection, Connection::make(options.address, options.authorities));
  BOOST_OUTCOME_TRY(watching, Connection::make(options.address, options.authorities));
  return Server(std::move(options), std::move(connection), std::move(watching));
}

void Server::authorize(HttpRequest& request) const {
  if (!options_.token.empty()) request.headers["Authorization"] = "Bearer " + options_.token;
}

Error Server::no_tessera() const {
  return error(Errc::usage, options_.address.text() + ": the server that answers is not a Tessera server");
}

Error Server::with_advice(Error failed) const {
  if (failed.code == Errc::usage && failed.where.find("certificate") != std::string::npos &&
      !options_.authorities_advice.empty())
    failed.where += "; " + options_.authorities_advice;
  return failed;
}

Error Server::refusal(const HttpAnswer& answer) const {
  if (!is_json(answer)) return no_tessera();
  proto::Problem problem;
  if (!read_message(answer.body, problem)) return no_tessera();
  const auto said = problem.detail().empty() ? problem.title() : sentence_of(problem);
  if (answer.status == 401) {
    return error(Errc::usage, options_.address.text() +
                                  (options_.token.empty() ? ": the server needs a token"
                                                          : ": the server does not know "
                                                            "this token") +
                                  (options_.token_advice.empty() ? "" : "; " + options_.token_advice));
  }
  if (said.empty()) {
    return error(code_of(answer.status, problem.cause()), options_.address.text() +
                                                              ": the server answers with status " +
                                                              std::to_string(answer.status) + ", and does not say why");
  }
  // An error without a cause is about the request, so it names the server.
  if (problem.cause() == 0) return error(code_of(answer.status, 0), options_.address.text() + ": " + said);
  return error(code_of(answer.status, problem.cause()), said);
}

Result<HttpAnswer> Server::answer_to(HttpRequest request, const std::stop_token& stop, const HttpReceiver& receiver) {
  authorize(request);
  request.headers.try_emplace("Accept", receiver.head ? "*/*" : "application/json");
  auto answer = connection_.ask(request, stop, receiver);
  if (!answer) return with_advice(answer.error());
  heard_ = true;
  return answer;
}

Result<HttpAnswer> Server::ask(HttpRequest request, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(answer, answer_to(std::move(request), stop));
  if (answer.status / 100 != 2) return refusal(answer);
  if (!is_json(answer)) return no_tessera();
  return std::move(answer);
}

template <class Message>
Result<Message> Server::ask_for(HttpRequest request, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(answer, ask(std::move(request), stop));
  Message message;
  if (!read_message(answer.body, message)) return no_tessera();
  return message;
}

namespace {

const auto& members(const proto::JobList& list) { return list.jobs(); }
const auto& members(const proto::TriangulationList& list) { return list.triangulations(); }
const auto& members(const proto::InputList& list) { return list.inputs(); }

}  // namespace

template <class List, class Member>
Result<std::vector<Member>> Server::ask_for_all(std::string target, std::size_t limit, const std::stop_token& stop) {
  std::vector<Member> all;
  while (true) {
    BOOST_OUTCOME_TRY(list, ask_for<List>({.target = target}, stop));
    const auto before = all.size();
    for (const auto& member : members(list)) {
      if (all.size() < limit) all.push_back(member);
    }
    const auto next = std::find_if(list.links().begin(), list.links().end(),
                                   [](const proto::Link& link) { return link.rel() == "next"; });
    // Stops at a page without members, which could go on for ever.
    if (next == list.links().end() || all.size() == limit || all.size() == before) return all;
    BOOST_OUTCOME_TRY(followed, follow_link(options_.address, target, next->href()));
    target = followed;
  }
}

HttpRequest Server::execution(const std::string& process, const nlohmann::ordered_json& inputs) const {
  HttpRequest request{.method = "POST", .target = target("/processes/" + process + "/execution")};
  request.headers = {{"Content-Type", "application/json"}};
  // In names that are not UTF-8, bytes become U+FFFD here, so the server does not find such files.
  request.body = json_text(nlohmann::ordered_json{{"inputs", inputs}});
  return request;
}

Result<proto::StatusInfo> Server::submit(const std::string& process, const nlohmann::ordered_json& inputs,
                                         const std::string& idempotency_key, const std::stop_token& stop) {
  auto request = execution(process, inputs);
  request.headers["Idempotency-Key"] = idempotency_key;
  request.headers["Prefer"] = "respond-async";
  return ask_for<proto::StatusInfo>(std::move(request), stop);
}

Result<Server::Told> Server::info(const nlohmann::ordered_json& inputs, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(answer, answer_to(execution("info", inputs), stop));
  Told told;
  if (answer.status / 100 == 2) {
    told.now = parse_ordered_json(answer.body);
    if (!is_json(answer) || !told.now.is_object()) return no_tessera();
    return told;
  }
  proto::Problem problem;
  if (!is_json(answer) || !read_message(answer.body, problem) || problem.type() != takes_a_job) return refusal(answer);
  BOOST_OUTCOME_TRY(job, submit("info", inputs, new_idempotency_key(), stop));
  told.job = std::move(job);
  return told;
}

Result<std::vector<proto::StatusInfo>> Server::jobs(const std::vector<std::string>& states, std::size_t limit,
                                                    const std::stop_token& stop) {
  constexpr std::size_t page = 1000;
  std::string query = "?limit=" + std::to_string(std::min(limit, page));
  if (!states.empty()) {
    std::string list;
    for (const auto& state : states) list += (list.empty() ? "" : ",") + percent_encoded(state);
    query += "&status=" + list;
  }
  return ask_for_all<proto::JobList, proto::StatusInfo>(target("/jobs" + query), limit, stop);
}

Result<proto::StatusInfo> Server::job(const std::string& id, const std::stop_token& stop) {
  return ask_for<proto::StatusInfo>({.target = target("/jobs/" + percent_encoded(id))}, stop);
}

Result<proto::StatusInfo> Server::dismiss(const std::string& id, const std::stop_token& stop) {
  // Not repeatable: the second request would forget the job.
  return ask_for<proto::StatusInfo>(
      {.method = "DELETE", .target = target("/jobs/" + percent_encoded(id)), .repeatable = false}, stop);
}

Result<proto::StatusInfo> Server::resume(const std::string& id, const std::stop_token& stop) {
  return ask_for<proto::StatusInfo>(
      {.method = "POST", .target = target("/jobs/" + percent_encoded(id) + "/resume"), .repeatable = false}, stop);
}

Result<nlohmann::ordered_json> Server::outcome(const std::string& id, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(answer, ask({.target = target("/jobs/" + percent_encoded(id) + "/results")}, stop));
  auto results = parse_ordered_json(answer.body);
  if (!results.is_object()) return no_tessera();
  auto& outcome = results["outcome"];
  if (!outcome.is_object() || !outcome["value"].is_object()) return no_tessera();
  return std::move(outcome["value"]);
}

Result<nlohmann::ordered_json> Server::versions(const std::string& name, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(answer, ask({.target = target("/triangulations/" + percent_encoded(name) + "/versions")}, stop));
  auto versions = parse_ordered_json(answer.body);
  if (!versions.is_object()) return no_tessera();
  return versions;
}

Result<std::vector<proto::TriangulationInfo>> Server::triangulations(const std::stop_token& stop) {
  return ask_for_all<proto::TriangulationList, proto::TriangulationInfo>(target("/triangulations"), SIZE_MAX, stop);
}

Result<std::vector<proto::InputInfo>> Server::inputs(const std::string& folder, const std::stop_token& stop) {
  return ask_for_all<proto::InputList, proto::InputInfo>(target("/inputs?folder=" + percent_encoded(folder)), SIZE_MAX,
                                                         stop);
}

Result<std::vector<proto::NodeInfo>> Server::nodes(const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(list, ask_for<proto::NodeList>({.target = target("/nodes")}, stop));
  return std::vector<proto::NodeInfo>(list.nodes().begin(), list.nodes().end());
}

Result<proto::NodeInfo> Server::drain(const std::string& node, const std::stop_token& stop) {
  // Not repeatable: the second request would find another node of that name, or none.
  return ask_for<proto::NodeInfo>(
      {.method = "POST", .target = target("/nodes/" + percent_encoded(node) + "/drain"), .repeatable = false}, stop);
}

// One connection to the events. Returns true when on_event has heard enough.
Result<bool> Server::listen(const std::string& id, std::string& last_id, bool& heard, const OnEvent& on_event,
                            const std::stop_token& stop) {
  HttpRequest request{.target = target("/jobs/" + percent_encoded(id) + "/events"), .repeatable = false};
  request.silence = silence_of_events;
  authorize(request);
  request.headers["Accept"] = "text/event-stream";
  if (!last_id.empty()) request.headers["Last-Event-ID"] = last_id;
  bool enough = false;
  const auto enough_of = [&](const proto::Event& event) -> Status {
    BOOST_OUTCOME_TRY(said, on_event(event));
    enough = said;
    // The stream does not end by itself, so it is ended by an error.
    if (enough) return error(Errc::ok, "");
    return success();
  };
  EventStream stream([&](const ServerEvent& sent) -> Status {
    if (!sent.id.empty()) last_id = sent.id;
    proto::Event event;
    if (!read_message(sent.data, event)) return no_tessera();
    return enough_of(event);
  });
  const auto take_head = [&](const HttpHead& head) -> Result<bool> {
    if (head.status != 200) return false;
    if (!head.header("content-type").starts_with("text/event-stream")) return no_tessera();
    heard = heard_ = true;
    // Events come from now on; what was before is in the status.
    proto::Event now;
    BOOST_OUTCOME_TRY(status, job(id, stop));
    now.set_kind("status");
    *now.mutable_status() = std::move(status);
    BOOST_OUTCOME_TRYV(enough_of(now));
    return true;
  };
  const HttpReceiver receiver{.head = take_head, .body = [&](std::string_view bytes) { return stream.feed(bytes); }};
  auto answer = watching_.ask(request, stop, receiver);
  if (enough) return true;
  if (!answer) return with_advice(answer.error());
  if (answer.value().status != 200) return refusal(answer.value());
  return false;
}

Status Server::events(const std::string& id, const OnEvent& on_event,
                      const std::function<void(const std::string&)>& on_gone, const std::stop_token& stop) {
  std::string last_id;
  bool told = false;
  Patience patience(options_.patience);
  while (true) {
    bool heard = false;
    const auto enough = listen(id, last_id, heard, on_event, stop);
    if (enough && enough.value()) return success();
    if (heard) {
      told = false;
      patience.restart();
    }
    if (enough) {
      BOOST_OUTCOME_TRYV(patience.pause(stop));
      continue;
    }
    // The server has never answered, or waiting does not help, or the error is the listener's own.
    if (!heard_ || enough.error().code != Errc::io) return enough.error();
    if (!told && options_.patience.count() > 0) on_gone(enough.error().where);
    told = true;
    BOOST_OUTCOME_TRYV(patience.wait(enough.error(), stop));
  }
}

}  // namespace tessera::client
