#include "src/service/problem.h"

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "src/base/option.h"
#include "src/service/json.h"

namespace tessera::service {
namespace {

constexpr const char* ogc = "http://www.opengis.net/def/exceptions/ogcapi-processes-1/1.0/";

const char* title_of(int status) {
  switch (status) {
    case 400:
      return "Bad Request";
    case 403:
      return "Forbidden";
    case 404:
      return "Not Found";
    case 409:
      return "Conflict";
    case 410:
      return "Gone";
    case 413:
      return "Content Too Large";
    case 422:
      return "Unprocessable Content";
    case 429:
      return "Too Many Requests";
    case 503:
      return "Service Unavailable";
    case 507:
      return "Insufficient Storage";
    default:
      return "Internal Server Error";
  }
}

// io_error() ends with the system's message.
bool disk_is_full(const Error& error) {
  const auto says = [&](int number) {
    return error.where.find(std::generic_category().message(number)) != std::string::npos;
  };
  return error.code == Errc::io && (says(ENOSPC) || says(EDQUOT) || says(EFBIG));
}

int status_of(const Error& error) {
  switch (error.code) {
    case Errc::usage:
      return 400;
    case Errc::bad_input:
    case Errc::memory:
      return 422;
    case Errc::interrupted:
      return 410;
    default:
      return disk_is_full(error) ? 507 : 500;
  }
}

}  // namespace

std::string field_name(std::string_view key, std::string_view value) {
  std::string name(key);
  if (key == "max-points-per-tile") name = "tile_points";
  if (key == "z") name = "heights";
  if (key == "index") name = "spatial_index";
  std::replace(name.begin(), name.end(), '-', '_');
  if (!value.empty()) name += ": " + std::string(value);
  return name;
}

proto::Problem problem(int status, std::string_view detail, Errc cause) {
  proto::Problem problem;
  problem.set_type("about:blank");
  problem.set_title(title_of(status));
  problem.set_status(status);
  problem.set_detail(as_utf8(render(detail, field_name)));
  if (!option_keys(detail).empty()) problem.set_marked(as_utf8(detail));
  problem.set_cause(static_cast<int>(cause));
  return problem;
}

proto::Problem problem_of(const Error& error) { return problem(status_of(error), error.where, error.code); }

proto::Problem reworded(proto::Problem problem, const std::function<std::string(const std::string&)>& how) {
  problem.set_detail(how(problem.detail()));
  if (problem.has_marked()) problem.set_marked(how(problem.marked()));
  return problem;
}

proto::Problem no_such_job(std::string_view id) {
  auto made = problem(404, "there is no job '" + std::string(id) + "'", Errc::usage);
  made.set_type(std::string(ogc) + "no-such-job");
  return made;
}

proto::Problem problem_of_inputs(const Error& error) {
  return error.code == Errc::io && !disk_is_full(error) ? problem(422, error.where, error.code) : problem_of(error);
}

proto::Problem needs_a_job(const std::string& what) {
  auto made = problem(400,
                      what +
                          " are not read while the request waits: send it again with the header Prefer: respond-async, "
                          "which makes it a job",
                      Errc::usage);
  made.set_type("urn:tessera:needs-a-job");
  return made;
}

proto::Problem result_not_ready(std::string_view id, std::string_view state) {
  auto made = problem(404, "job " + std::string(id) + " is " + std::string(state) + ": it has no result yet");
  made.set_type(std::string(ogc) + "result-not-ready");
  return made;
}

}  // namespace tessera::service
