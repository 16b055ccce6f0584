#include "src/service/http/message.h"

#include <algorithm>
#include <cstdlib>

#include "src/service/json.h"
#include "src/service/questions/questions_backend.h"

namespace tessera::service::http {
namespace {

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

// The caller's preference for `type` (RFC 9110, 12.5.1), from the most precise range that matches; 0: not at all.
double quality(std::string_view accept, std::string_view type) {
  if (accept.empty()) return 1;
  const std::string all_of_kind = std::string(type.substr(0, type.find('/'))) + "/*";
  double found = 0;
  int precision = 0;
  while (!accept.empty()) {
    const std::size_t end = std::min(accept.find(','), accept.size());
    const std::string_view range = accept.substr(0, end);
    accept.remove_prefix(std::min(end + 1, accept.size()));
    const std::string name = media_type(range);
    const int how = name == type ? 3 : name == all_of_kind ? 2 : name == "*/*" ? 1 : 0;
    if (how <= precision) continue;
    precision = how;
    const std::size_t q = range.find("q=");
    found = q == std::string_view::npos ? 1 : std::atof(std::string(range.substr(q + 2)).c_str());
  }
  return found;
}

}  // namespace

std::string_view Request::header(std::string_view name) const {
  for (const auto& [key, value] : headers)
    if (key == name) return value;
  return {};
}

std::size_t Request::count(std::string_view name) const {
  return static_cast<std::size_t>(
      std::count_if(headers.begin(), headers.end(), [&](const auto& header) { return header.first == name; }));
}

std::string_view reason_phrase(int status) {
  switch (status) {
    case 200:
      return "OK";
    case 201:
      return "Created";
    case 204:
      return "No Content";
    case 206:
      return "Partial Content";
    case 303:
      return "See Other";
    case 304:
      return "Not Modified";
    case 400:
      return "Bad Request";
    case 401:
      return "Unauthorized";
    case 403:
      return "Forbidden";
    case 404:
      return "Not Found";
    case 405:
      return "Method Not Allowed";
    case 408:
      return "Request Timeout";
    case 409:
      return "Conflict";
    case 410:
      return "Gone";
    case 412:
      return "Precondition Failed";
    case 411:
      return "Length Required";
    case 413:
      return "Content Too Large";
    case 415:
      return "Unsupported Media Type";
    case 416:
      return "Range Not Satisfiable";
    case 417:
      return "Expectation Failed";
    case 421:
      return "Misdirected Request";
    case 422:
      return "Unprocessable Content";
    case 429:
      return "Too Many Requests";
    case 431:
      return "Request Header Fields Too Large";
    case 500:
      return "Internal Server Error";
    case 501:
      return "Not Implemented";
    case 503:
      return "Service Unavailable";
    case 507:
      return "Insufficient Storage";
    default:
      return "Status";
  }
}

std::string media_type(std::string_view content_type) {
  std::string type(trimmed(content_type.substr(0, content_type.find(';'))));
  std::transform(type.begin(), type.end(), type.begin(), [](char c) { return c >= 'A' && c <= 'Z' ? c + 32 : c; });
  return type;
}

bool prefers(const Request& request, std::string_view type, std::string_view usual) {
  const std::string_view accept = request.header("accept");
  return !accept.empty() && quality(accept, type) > quality(accept, usual);
}

Answer problem(int status, std::string detail, int cause, std::string type) {
  proto::Problem told;
  told.set_status(status);
  told.set_detail(std::move(detail));
  told.set_cause(cause);
  told.set_type(std::move(type));
  return problem(told);
}

Answer problem(const proto::Problem& told) {
  Answer answer;
  answer.problem = told;
  proto::Problem& mine = *answer.problem;
  // An invalid status would break the protocol.
  if (mine.status() < 400 || mine.status() > 599) mine.set_status(500);
  answer.status = mine.status();
  if (mine.type().empty()) mine.set_type("about:blank");
  if (mine.title().empty()) mine.set_title(std::string(reason_phrase(mine.status())));
  if (answer.status == 429 || answer.status == 503) answer.headers.emplace_back("Retry-After", "5");
  return answer;
}

Answer json_answer(int status, std::string text) {
  Answer answer;
  answer.status = status;
  answer.headers.emplace_back("Content-Type", "application/json");
  answer.body = std::move(text);
  return answer;
}

Answer message_answer(const Request& request, int status, const google::protobuf::Message& message) {
  Answer answer = json_answer(status, {});
  if (prefers(request, protobuf_type)) {
    answer.headers.back().second = protobuf_type;
    answer.body = message.SerializeAsString();
  } else {
    answer.body = to_json(message);
  }
  answer.headers.emplace_back("Vary", "Accept");
  return answer;
}

void write_problem(const Request& request, Answer& answer) {
  if (!answer.problem) return;
  answer.problem->set_instance(request.target.path);
  answer.headers.emplace_back("Content-Type", "application/problem+json");
  answer.body = to_json(*answer.problem);
}

}  // namespace tessera::service::http
