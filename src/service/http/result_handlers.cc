#include <algorithm>
#include <charconv>
#include <filesystem>
#include <utility>

#include "src/base/files/names.h"
#include "src/service/http/handlers.h"
#include "src/service/http/ranges.h"

namespace tessera::service::http {
namespace {

Answer no_content() {
  Answer answer;
  answer.status = 204;
  return answer;
}

Answer triangulations(const Call& call) {
  const Result<std::uint32_t> limit = limit_of(call.request);
  if (!limit) return bad_request(limit.error());
  Reply<proto::TriangulationList> found =
      call.context.backend->results.list(limit.value(), call.request.target.parameter("after").value_or(""));
  if (!found) return problem(found.error());
  proto::TriangulationList& list = found.value();
  for (proto::TriangulationInfo& one : *list.mutable_triangulations()) call.context.links.add(call.request, one);
  list.clear_links();
  *list.add_links() = call.context.links.link(call.request, "/v1/triangulations", "self", json);
  if (list.triangulations_size() > 0 && static_cast<std::uint32_t>(list.triangulations_size()) == limit.value()) {
    const std::string& last = list.triangulations(list.triangulations_size() - 1).name();
    const std::string next =
        "/v1/triangulations?limit=" + std::to_string(limit.value()) + "&after=" + encode_segment(last);
    *list.add_links() = call.context.links.link(call.request, next, "next", json);
  }
  return message_answer(call.request, 200, list);
}

Answer triangulation(const Call& call) {
  Reply<proto::TriangulationInfo> found = call.context.backend->results.info(call.arguments[0]);
  if (!found) return problem(found.error());
  if (auto live = call.context.backend->live.live(call.arguments[0])) *found.value().mutable_live() = std::move(*live);
  call.context.links.add(call.request, found.value());
  return message_answer(call.request, 200, found.value());
}

Answer versions(const Call& call) {
  Reply<std::string> found = call.context.backend->results.versions(call.arguments[0]);
  if (!found) return problem(found.error());
  return json_answer(200, std::move(found).value());
}

Answer remove(const Call& call) {
  const Reply<void> removed = call.context.backend->results.remove(call.arguments[0], call.request.caller);
  return removed ? no_content() : problem(removed.error());
}

Answer file(const Call& call) {
  const Reply<ServedFile> found = call.context.backend->results.file(call.arguments[0], call.arguments[1]);
  return found ? file_answer(call.request, found.value()) : problem(found.error());
}

// The files of the tileset that the dashboard shows, where programs expect a tileset.
Answer tileset_file_of(const Call& call) {
  const std::filesystem::path path = tileset_of_result("") / call.arguments[1];
  const Reply<ServedFile> found = call.context.backend->results.file(call.arguments[0], path.string());
  if (found) return file_answer(call.request, found.value());
  if (found.error().status() != 404) return problem(found.error());
  return problem(404,
                 "triangulation '" + call.arguments[0] +
                     "' has no such file of a tileset; the process export makes the tileset of a 2D result, the "
                     "process surface that of a 3D result: format 3dtiles, output " +
                     tileset_of_result("").filename().string(),
                 2);
}

Answer remove_export(const Call& call) {
  const std::string begin = exports_folder("").string() + "/";
  const std::string& path = call.arguments[1];
  if (!path.starts_with(begin))
    return problem(
        404, "there is no export at this address, and other files are removed only together with their triangulation",
        2);
  const Reply<void> removed =
      call.context.backend->results.remove_export(call.arguments[0], path.substr(begin.size()), call.request.caller);
  return removed ? no_content() : problem(removed.error());
}

Answer uploaded(const Call& call) {
  const Reply<std::uint64_t> bytes = call.context.backend->inputs.uploaded(call.arguments[0], call.arguments[1]);
  if (!bytes) return problem(bytes.error());
  Answer answer;
  answer.status = 204;
  answer.headers.emplace_back("Upload-Offset", std::to_string(bytes.value()));
  return answer;
}

Answer remove_upload(const Call& call) {
  const Reply<void> removed =
      call.context.backend->inputs.remove_upload(call.arguments[0], call.arguments[1], call.request.caller);
  return removed ? no_content() : problem(removed.error());
}

Reply<std::unique_ptr<Upload>> upload(const Call& call) {
  std::uint64_t offset = 0;
  const std::string_view text = call.request.header("upload-offset");
  if (!text.empty()) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), offset);
    if (error != std::errc() || end != text.data() + text.size()) {
      proto::Problem problem;
      problem.set_status(400);
      problem.set_cause(2);
      problem.set_detail("Upload-Offset: is not a number of bytes");
      return problem;
    }
  }
  return call.context.backend->inputs.upload(call.arguments[0], call.arguments[1], offset, call.request.caller);
}

}  // namespace

Result<std::uint32_t> limit_of(const Request& request) {
  constexpr std::uint32_t usual = 100, max = 1000;
  const auto text = request.target.parameter("limit");
  if (!text) return usual;
  std::uint32_t limit = 0;
  const auto [end, failed] = std::from_chars(text->data(), text->data() + text->size(), limit);
  if (failed == std::errc::result_out_of_range && end == text->data() + text->size()) return max;
  if (failed != std::errc() || end != text->data() + text->size() || limit == 0)
    return error(Errc::usage, "limit: must be a whole number, at least 1");
  return std::min(limit, max);
}

Answer bad_request(const Error& error) { return problem(400, error.where, static_cast<int>(error.code)); }

void add_result_routes(std::vector<Route>& routes) {
  const std::vector<Parameter> paging{{"limit", "integer", "How many entries a page has at most"},
                                      {"after", "string", "The last entry of the page before"}};
  routes.push_back({"GET",
                    "/v1/triangulations",
                    Role::read,
                    "listTriangulations",
                    "The results, in pages",
                    {{200, json, "TriangulationList", "The results"}},
                    triangulations,
                    paging});
  routes.push_back({"GET",
                    "/v1/triangulations/{triangulation}",
                    Role::read,
                    "getTriangulation",
                    "A result",
                    {{200, json, "TriangulationInfo", "The result"}},
                    triangulation});
  routes.push_back({"GET",
                    "/v1/triangulations/{triangulation}/versions",
                    Role::read,
                    "listVersions",
                    "The versions of a result: when each was made, and what it added and removed",
                    {{200, json, "Document", "The versions, as tessera log prints them"}},
                    versions});
  routes.push_back({"DELETE",
                    "/v1/triangulations/{triangulation}",
                    Role::submit,
                    "removeTriangulation",
                    "Remove a result and its exports for good",
                    {{204, "", "", "It was removed"}},
                    remove});
  routes.push_back({"GET",
                    "/v1/triangulations/{triangulation}/files/{path*}",
                    Role::read,
                    "getFile",
                    "A file of a result, or a range of its bytes",
                    {{200, "application/octet-stream", "", "The file"},
                     {206, "application/octet-stream", "", "A part of it"},
                     {304, "", "", "The file is the one that If-None-Match names"}},
                    file});
  routes.push_back({"GET",
                    "/v1/triangulations/{triangulation}/3dtiles/{path*}",
                    Role::read,
                    "getTileset",
                    "A result as 3D Tiles 1.1: tileset.json and the files that it names",
                    {{200, json, "", "The tileset"},
                     {200, "model/gltf-binary", "", "The surface of a node of the tileset"},
                     {304, "", "", "The file is the one that If-None-Match names"}},
                    tileset_file_of});
  routes.push_back({"DELETE",
                    "/v1/triangulations/{triangulation}/files/{path*}",
                    Role::submit,
                    "removeExport",
                    "Remove an export of a triangulation, the file exports/NAME",
                    {{204, "", "", "It was removed"}},
                    remove_export});
  routes.push_back({"HEAD",
                    "/v1/uploads/{upload}/{file}",
                    Role::submit,
                    "getUpload",
                    "How many bytes of an upload have arrived",
                    {{204, "", "", "The header Upload-Offset has the number of bytes"}},
                    uploaded});
  routes.push_back({"DELETE",
                    "/v1/uploads/{upload}/{file}",
                    Role::submit,
                    "removeUpload",
                    "Remove an upload, complete or not",
                    {{204, "", "", "It was removed"}},
                    remove_upload});
  Route put{"PUT",
            "/v1/uploads/{upload}/{file}",
            Role::submit,
            "putUpload",
            "Upload an input file; with the header Upload-Offset, the rest of it after that many bytes",
            {{204, "", "", "The whole file has arrived"}},
            [](const Call&) { return no_content(); },
            {},
            "bytes"};
  put.upload = upload;
  routes.push_back(std::move(put));
}

}  // namespace tessera::service::http
