// Requests about results, their files, and uploads.
#include <algorithm>
#include <charconv>
#include <utility>

#include "src/base/files/names.h"
#include "src/service/client/messages.h"
#include "src/service/client/server.h"

namespace tessera::client {

Result<std::optional<proto::TriangulationInfo>> Server::triangulation(const std::string& name,
                                                                      const std::stop_token& stop) {
  HttpRequest request{.target = target("/triangulations/" + percent_encoded(name))};
  BOOST_OUTCOME_TRY(answer, answer_to(std::move(request), stop));
  proto::TriangulationInfo info;
  if (answer.status == 404 && is_json(answer)) return std::optional<proto::TriangulationInfo>();
  if (answer.status != 200) return refusal(answer);
  if (!is_json(answer) || !read_message(answer.body, info)) return no_tessera();
  return std::optional(std::move(info));
}

std::string Server::file_target(const std::string& triangulation, const std::string& path) const {
  std::string where = target("/triangulations/" + percent_encoded(triangulation) + "/files");
  for (std::size_t at = 0; at <= path.size();) {
    const auto end = std::min(path.find('/', at), path.size());
    where += "/" + percent_encoded(std::string_view(path).substr(at, end - at));
    at = end + 1;
  }
  return where;
}

Status Server::remove_export(const std::string& triangulation, const std::string& file, const std::stop_token& stop) {
  HttpRequest request{.method = "DELETE", .target = file_target(triangulation, exports_folder("") / file)};
  BOOST_OUTCOME_TRY(answer, answer_to(std::move(request), stop));
  if (answer.status / 100 != 2) return refusal(answer);
  return success();
}

Result<HttpAnswer> Server::file(const std::string& triangulation, const std::string& path, std::uint64_t from,
                                const std::string& etag, const HttpReceiver& receiver, const std::stop_token& stop) {
  HttpRequest request{.target = file_target(triangulation, path)};
  if (from > 0) {
    request.headers["Range"] = "bytes=" + std::to_string(from) + "-";
    if (!etag.empty()) request.headers["If-Range"] = etag;
  }
  BOOST_OUTCOME_TRY(answer, answer_to(std::move(request), stop, receiver));
  if (answer.status / 100 != 2 && answer.status != 416) return refusal(answer);
  return answer;
}

Result<std::uint64_t> Server::uploaded(const std::string& folder, const std::string& file,
                                       const std::stop_token& stop) {
  HttpRequest request{.method = "HEAD", .target = upload_target(folder, file)};
  BOOST_OUTCOME_TRY(answer, answer_to(std::move(request), stop));
  if (answer.status == 404) return std::uint64_t{0};
  const auto& text = answer.header("upload-offset");
  std::uint64_t bytes = 0;
  const auto [end, wrong] = std::from_chars(text.data(), text.data() + text.size(), bytes);
  if (answer.status == 204 && wrong == std::errc{} && end == text.data() + text.size()) return bytes;
  // The answer to HEAD has no sentence.
  return error(code_of(answer.status, 0), options_.address.text() + ": the server refuses the upload with status " +
                                              std::to_string(answer.status));
}

Status Server::upload(const std::string& folder, const std::string& file, std::uint64_t from, std::uint64_t bytes,
                      std::function<Result<std::size_t>(std::span<char>)> source, int& answer,
                      const std::stop_token& stop) {
  answer = 0;
  HttpRequest request{.method = "PUT", .target = upload_target(folder, file), .repeatable = false};
  request.headers["Content-Type"] = "application/octet-stream";
  if (from > 0) request.headers["Upload-Offset"] = std::to_string(from);
  request.source_bytes = bytes;
  request.source = std::move(source);
  BOOST_OUTCOME_TRY(told, answer_to(std::move(request), stop));
  answer = told.status;
  if (answer / 100 != 2) return refusal(told);
  return success();
}

}  // namespace tessera::client
