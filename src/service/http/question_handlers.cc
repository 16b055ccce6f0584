// Questions to results. An answer depends only on the result and the question, so its ETag is known before the answer.
#include <algorithm>
#include <span>
#include <utility>

#include "src/base/files/checksum.h"
#include "src/service/http/handlers.h"
#include "src/service/http/ranges.h"

namespace tessera::service::http {
namespace {

using About = Question::About;

constexpr const char* json = "application/json";
constexpr const char* csv = "text/csv";
constexpr const char* npy = "application/x-npy";
constexpr const char* geojson = "application/geo+json";
constexpr const char* gltf = "model/gltf-binary";
constexpr const char* bytes = "application/octet-stream";
constexpr const char* tiff = "image/tiff; application=geotiff; profile=cloud-optimized";

// The ETag of the answer to a GET: depends on the result, the question and the form of the answer.
std::string tag_of(const std::string& identity, const Request& request, bool as_message) {
  std::string text = identity + (as_message ? protobuf_type : "");
  for (const std::string& segment : request.target.segments) text += '\n' + segment;
  for (const auto& [key, value] : request.target.query) text += '\n' + key + '\n' + value;
  return "\"answer-" + checksum_text(checksum(std::as_bytes(std::span(text)))) + "\"";
}

// True if the answer is to be a message. `type` is the type of the body, which the answer has, too, unless Accept or
// the option `f` says otherwise.
bool wants_message(const Request& request, About about, const std::string& type) {
  if (!has_message(about) || request.target.parameter("f")) return false;
  if (type == protobuf_type) return !prefers(request, json, protobuf_type);
  return prefers(request, protobuf_type, about == About::profile ? csv : type.empty() ? json : type);
}

Answer answer_of(QuestionAnswer found) {
  Answer answer;
  if (found.file) {
    answer.headers.emplace_back("Content-Type", found.file->type);
    answer.file = FilePart{FileHandle(found.file->descriptor), 0, found.file->bytes};
  } else {
    answer.headers.emplace_back("Content-Type", found.type);
    answer.body = std::move(found.text);
  }
  answer.headers.emplace_back("Tessera-Final", found.final ? "true" : "false");
  return answer;
}

Question question_of(const Call& call, About about, const std::string& type = {}) {
  Question question{.about = about,
                    .triangulation = call.arguments[0],
                    .type = type,
                    .as_message = wants_message(call.request, about, type),
                    .stop = call.request.stop};
  if (call.arguments.size() > 1) question.vertex = call.arguments[1];
  for (const auto& [key, value] : call.request.target.query) question.options.emplace(key, value);
  return question;
}

Handler asks(About about) {
  return [about](const Call& call) {
    const Reply<std::string> identity = call.context.backend->questions.identity(call.arguments[0]);
    if (!identity) return problem(identity.error());
    const Question question = question_of(call, about);
    const std::string tag = tag_of(identity.value(), call.request, question.as_message);
    Answer answer;
    if (names_tag(call.request.header("if-none-match"), tag, true)) {
      answer.status = 304;
    } else {
      Reply<QuestionAnswer> found = call.context.backend->questions.ask(question);
      if (!found) return problem(found.error());
      answer = answer_of(std::move(found).value());
    }
    answer.headers.emplace_back("ETag", tag);
    if (has_message(about)) answer.headers.emplace_back("Vary", "Accept");
    // Another result may have this name one day.
    answer.headers.emplace_back("Cache-Control", "private, no-cache");
    return answer;
  };
}

// `types` are the allowed types of a body; parameters of a type are ignored.
Handler asks_with_body(About about, std::vector<std::string> types) {
  return [about, types = std::move(types)](const Call& call) {
    Question question = question_of(call, about, media_type(call.request.header("content-type")));
    if (std::find(types.begin(), types.end(), question.type) == types.end()) {
      std::string list;
      for (const std::string& type : types) list += (list.empty() ? "" : ", ") + type;
      return problem(415, "Content-Type: must be one of " + list, 2);
    }
    question.body = call.request.body;
    Reply<QuestionAnswer> found = call.context.backend->questions.ask(question);
    if (!found) return problem(found.error());
    Answer answer = answer_of(std::move(found).value());
    if (has_message(about)) answer.headers.emplace_back("Vary", "Accept");
    return answer;
  };
}

Route route(const char* method, const char* path, const char* name, const char* summary,
            std::vector<Response> responses, Handler handler, std::vector<Parameter> query) {
  Route made{method,
             std::string("/v1/triangulations/{triangulation}/") + path,
             Role::read,
             name,
             summary,
             std::move(responses),
             std::move(handler),
             std::move(query)};
  made.runs = Runs::questions;
  if (made.method == "GET") made.responses.push_back({304, "", "", "It is the answer that If-None-Match names"});
  return made;
}

}  // namespace

void add_question_routes(std::vector<Route>& routes) {
  const Parameter bbox{"bbox", "string", "xmin,ymin,xmax,ymax; in 3D also xmin,ymin,zmin,xmax,ymax,zmax"};
  const Parameter cell_format{"f", "string", "A format of the process export; geojson in 2D, ply in 3D"};
  const Parameter limit{"limit", "integer", "The most cells that are wanted: an area with more is refused"};
  const Parameter answer_format{"f", "string", "json, csv or npy; as the points came, or as Accept says"};
  const std::vector<Response> many{{200, json, "Answers", "One for each point, in their order"},
                                   {200, csv, "", "One for each point, in their order"},
                                   {200, npy, "", "One for each point, in their order"}};
  const std::vector<Response> mesh{{200, geojson, "", "The cells, in the format that was asked for"},
                                   {200, "application/vnd.ply", "", "The cells, in the format that was asked for"},
                                   {200, bytes, "", "The cells, in the format that was asked for"}};

  routes.push_back(route("GET", "locate", "locate", "The cell that has a point",
                         {{200, json, "Location", "The cell, its vertices and neighbours; null outside the hull"}},
                         asks(About::locate),
                         {{"point", "string", "x,y or x,y,z"},
                          {"cell", "string", "Instead of a point: TILE,CELL, as answers name cells"}}));
  Route locate = route("POST", "locate", "locatePoints", "The cells that have points", many,
                       asks_with_body(About::locate, {json, csv, npy, protobuf_type, bytes}), {answer_format});
  locate.body = "Points";
  locate.body_types = {csv, npy, protobuf_type};
  routes.push_back(std::move(locate));
  routes.push_back(route("GET", "vertices/{vertex}/star", "getStar", "What is around a vertex",
                         {{200, json, "Star", "Its cells, neighbours and Voronoi volume"}}, asks(About::star),
                         {{"tile", "integer", "The tile that owns the vertex, if it is known"}}));
  routes.push_back(route("GET", "vertices/{vertex}/neighbours", "getNeighbours", "Which vertices share an edge with it",
                         {{200, json, "Neighbours", "Their source indices, ascending"}}, asks(About::neighbours),
                         {{"tile", "integer", "The tile that owns the vertex, if it is known"}}));
  routes.push_back(route("GET", "cells", "getCells", "The cells that meet a box", mesh, asks(About::cells),
                         {bbox, cell_format, limit}));
  Route cells = route("POST", "cells", "getCellsOfPolygon", "The cells that meet polygons", mesh,
                      asks_with_body(About::cells, {geojson, json}), {cell_format, limit});
  cells.body = "Document";
  cells.body_types = {geojson};
  routes.push_back(std::move(cells));
  Route interpolate = route("POST", "interpolate", "interpolate", "Values at points", many,
                            asks_with_body(About::interpolate, {json, csv, npy, protobuf_type, bytes}),
                            {{"value", "string", "An attribute of the vertices; z, the heights, in 2D"},
                             {"method", "string", "linear or natural"},
                             {"weights", "boolean", "Also of which vertices a value is made, and how much of each"},
                             answer_format});
  interpolate.body = "Points";
  interpolate.body_types = {csv, npy, protobuf_type};
  routes.push_back(std::move(interpolate));
  routes.push_back(route("GET", "dem", "getDem", "The surface of a 2D result as a raster",
                         {{200, tiff, "", "The raster"}}, asks(About::dem),
                         {bbox,
                          {"res", "number", "The width of a pixel"},
                          {"max-edge", "number", "No pixels in cells with a longer edge"},
                          {"value", "string", "An attribute of the vertices; z"},
                          {"type", "string", "float32 or float64"}}));
  const Parameter max_edge{"max-edge", "number", "Cells with a longer edge are left out"};
  const Parameter value{"value", "string", "An attribute of the vertices; z"};
  routes.push_back(route("GET", "contours", "getContours", "The contour lines of a 2D result",
                         {{200, geojson, "", "The lines, in the coordinates of the result"},
                          {200, "application/geopackage+sqlite3", "", "The lines"}},
                         asks(About::contours),
                         {bbox,
                          {"interval", "number", "Between levels, in units of the heights"},
                          {"base", "number", "A level; 0"},
                          max_edge,
                          value,
                          {"smooth", "number", "Lines of a smooth surface: means in squares of this size"},
                          {"min-length", "number", "Lines that are shorter in the plane are left out"},
                          {"index-every", "integer", "Every N-th level, from base on, is an index line; default: 5"},
                          {"f", "string", "geojson or gpkg"}}));
  const std::vector<Response> heights{{200, csv, "", "A line for each place where the profile bends"},
                                      {200, json, "Profile", "The same"},
                                      {200, geojson, "", "Lines with the value as third coordinate"}};
  const Parameter digits{"digits", "string", "Of csv: decimals, 0 to 17, or all; as the data carry"};
  const Parameter profile_format{"f", "string", "csv, json or geojson; csv, or as Accept says"};
  routes.push_back(route("GET", "profile", "getProfile", "The heights of a 2D result along a line", heights,
                         asks(About::profile),
                         {{"line", "string", "x,y x,y ..."}, max_edge, value, digits, profile_format}));
  Route profile = route("POST", "profile", "getProfileOfLine", "The heights of a 2D result along a line", heights,
                        asks_with_body(About::profile, {geojson, json}), {max_edge, value, digits, profile_format});
  profile.body = "Document";
  profile.body_types = {geojson};
  routes.push_back(std::move(profile));

  const std::string place = "x,y,z";
  const std::vector<Response> shape{{200, gltf, "", "Binary glTF, quantised and compressed; each cell by itself"}};
  routes.push_back(route("GET", "shapes/hull", "getHull",
                         "The hull of a 3D result, or the border of its cells without long edges, to be shown", shape,
                         asks(About::hull), {max_edge, limit}));
  routes.push_back(route("GET", "shapes/section", "getSection", "What a plane cuts out of a 3D result, to be shown",
                         shape, asks(About::section),
                         {{"through", "string", place + ": a point of the plane"},
                          {"normal", "string", place + ": upright on it"},
                          bbox,
                          max_edge,
                          limit}));
  routes.push_back(route(
      "GET", "shapes/cells", "getSolids", "The tetrahedra that meet a box, to be shown", shape, asks(About::solids),
      {bbox, {"shrink", "number", "Each towards its mean; from 0.01 to 1, which is the usual"}, max_edge, limit}));
}

}  // namespace tessera::service::http
