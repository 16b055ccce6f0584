// Lists of what can be downloaded or chosen: the exports of results, and inputs.
#include <utility>

#include "src/base/files/names.h"
#include "src/service/http/handlers.h"

namespace tessera::service::http {
namespace {

constexpr const char* map_relation = "http://www.opengis.net/def/rel/ogc/1.0/tilesets-map";

// Adds links to the export's bytes and to what shows it: a map, features, a tileset.
void add_links(const Call& call, proto::ExportInfo& made) {
  const Links& links = call.context.links;
  const Backend& backend = *call.context.backend;
  const std::string& name = call.arguments[0];
  const std::string self = triangulation_path(name);
  made.clear_links();
  if (made.name() == tileset_of_result("").filename()) {
    *made.add_links() =
        links.link(call.request, self + "/3dtiles/tileset.json", "item", json, "The export as 3D Tiles");
    return;
  }
  const std::string path = (exports_folder("") / made.name()).string();
  if (const auto file = backend.results.file(name, path)) {
    const FileHandle opened(file.value().descriptor);
    *made.add_links() = links.link(call.request, file_path(name, path), "item", file.value().type, "The file");
  }
  if (made.name() == "dem.tif" && backend.questions.map_extent(name))
    *made.add_links() = links.link(call.request, self + "/map/tiles", map_relation, json, "The export as a map");
  if (const std::string id = name + ".contours"; made.name() == "contours.gpkg" && backend.questions.collection(id))
    *made.add_links() =
        links.link(call.request, "/v1/collections/" + encode_segment(id), "collection", json, "The export as features");
}

Answer exports(const Call& call) {
  const Result<std::uint32_t> limit = limit_of(call.request);
  if (!limit) return bad_request(limit.error());
  Reply<proto::ExportList> found = call.context.backend->results.exports(
      call.arguments[0], limit.value(), call.request.target.parameter("after").value_or(""));
  if (!found) return problem(found.error());
  proto::ExportList& list = found.value();
  for (proto::ExportInfo& one : *list.mutable_exports()) add_links(call, one);
  const std::string self = triangulation_path(call.arguments[0]) + "/exports";
  *list.add_links() = call.context.links.link(call.request, self, "self", json);
  if (list.exports_size() > 0 && static_cast<std::uint32_t>(list.exports_size()) == limit.value()) {
    const std::string next = self + "?limit=" + std::to_string(limit.value()) +
                             "&after=" + encode_segment(list.exports(list.exports_size() - 1).name());
    *list.add_links() = call.context.links.link(call.request, next, "next", json);
  }
  return message_answer(call.request, 200, list);
}

Answer inputs(const Call& call) {
  const Result<std::uint32_t> limit = limit_of(call.request);
  if (!limit) return bad_request(limit.error());
  const std::string folder(call.request.target.parameter("folder").value_or(""));
  Reply<proto::InputList> found = call.context.backend->inputs.list(
      folder, limit.value(), call.request.target.parameter("after").value_or(""), call.request.caller);
  if (!found) return problem(found.error());
  proto::InputList& list = found.value();
  const std::string self = "/v1/inputs?folder=" + encode_segment(folder);
  *list.add_links() = call.context.links.link(call.request, self, "self", json);
  if (list.inputs_size() > 0 && static_cast<std::uint32_t>(list.inputs_size()) == limit.value()) {
    const std::string next = self + "&limit=" + std::to_string(limit.value()) +
                             "&after=" + encode_segment(list.inputs(list.inputs_size() - 1).name());
    *list.add_links() = call.context.links.link(call.request, next, "next", json);
  }
  return message_answer(call.request, 200, list);
}

}  // namespace

void add_listing_routes(std::vector<Route>& routes) {
  const Parameter limit{"limit", "integer", "How many entries a page has at most"},
      after{"after", "string", "The last entry of the page before"};
  routes.push_back({"GET",
                    "/v1/triangulations/{triangulation}/exports",
                    Role::read,
                    "listExports",
                    "The exports of a result: rasters, lines, meshes",
                    {{200, json, "ExportList", "The exports, sorted by name, in pages"}},
                    exports,
                    {limit, after}});
  Route choice{
      "GET",
      "/v1/inputs",
      Role::submit,
      "listInputs",
      "The point files and folders in a folder that jobs may read",
      {{200, json, "InputList", "The files and folders, sorted by name, in pages"}},
      inputs,
      {{"folder", "string",
        "The name of a folder in another answer; default: all folders that are configured for inputs, and the uploads"},
       limit,
       after}};
  choice.runs = Runs::changes;
  routes.push_back(std::move(choice));
}

}  // namespace tessera::service::http
