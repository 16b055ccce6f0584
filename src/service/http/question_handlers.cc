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

constexpr const char* csv = "text/csv";
constexpr const char* npy = "application/x-npy";
constexpr const char* geojson_type = "application/geo+json";
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
  answer.headers.emplace_back("Tessera-Version", std::to_string(found.version));
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
    const bool may_change = identity.value().empty();
    const std::string tag = tag_of(identity.value(), call.request, question.as_message);
    Answer answer;
    if (!may_change && names_tag(call.request.header("if-none-match"), tag, true)) {
      answer.status = 304;
    } else {
      Reply<QuestionAnswer> found = call.context.backend->questions.ask(question);
      if (!found) return problem(found.error());
      answer = answer_of(std::move(found).value());
    }
    if (!may_change) answer.headers.emplace_back("ETag", tag);
    if (has_message(about)) answer.headers.emplace_back("Vary", "Accept");
    // Another result may have this name one day.
    answer.headers.emplace_back("Cache-Control", may_change ? "no-store" : "private, no-cache");
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
  made.query.push_back({"version", "integer", "The version of the result, if it is still kept; default: the newest"});
  if (made.method == "GET") made.responses.push_back({304, "", "", "The answer is the one that If-None-Match names"});
  return made;
}

}  // namespace

void add_question_routes(std::vector<Route>& routes) {
  const Parameter bbox{"bbox", "string", "The box xmin,ymin,xmax,ymax; in 3D also xmin,ymin,zmin,xmax,ymax,zmax"};
  const Parameter cell_format{"f", "string", "A format of the process export; default: geojson in 2D, ply in 3D"};
  const Parameter limit{"limit", "integer",
                        "How many cells the answer may have at most: a question with more is refused"};
  const Parameter answer_format{
      "f", "string", "The format of the answer: json, csv or npy; default: the format in Accept, or that of the body"};
  const std::vector<Response> many{{200, json, "Answers", "One answer for each point, in their order"},
                                   {200, csv, "", "One answer for each point, in their order"},
                                   {200, npy, "", "One answer for each point, in their order"}};
  const std::vector<Response> mesh{{200, geojson_type, "", "The cells, in the format f"},
                                   {200, "application/vnd.ply", "", "The cells, in the format f"},
                                   {200, bytes, "", "The cells, in the format f"}};

  routes.push_back(
      route("GET", "locate", "locate", "The cell that contains a point",
            {{200, json, "Location", "The cell, its vertices and neighbours; null when the point is outside the hull"}},
            asks(About::locate),
            {{"point", "string", "The point: x,y or x,y,z"},
             {"cell", "string", "Instead of point: TILE,CELL, the two numbers of a cell in another answer"}}));
  Route locate = route("POST", "locate", "locatePoints", "The cells that contain points", many,
                       asks_with_body(About::locate, {json, csv, npy, protobuf_type, bytes}), {answer_format});
  locate.body = "Points";
  locate.body_types = {csv, npy, protobuf_type};
  routes.push_back(std::move(locate));
  routes.push_back(route(
      "GET", "vertices/{vertex}/star", "getStar", "The star of a vertex: the cells around it",
      {{200, json, "Star", "The cells, neighbours and Voronoi volume of the vertex"}}, asks(About::star),
      {{"tile", "integer", "The tile that owns the vertex, if it is known, which saves the search for the tile"}}));
  routes.push_back(route(
      "GET", "vertices/{vertex}/neighbours", "getNeighbours", "The vertices that share an edge with a vertex",
      {{200, json, "Neighbours", "The source indices of the neighbours, ascending"}}, asks(About::neighbours),
      {{"tile", "integer", "The tile that owns the vertex, if it is known, which saves the search for the tile"}}));
  routes.push_back(route("GET", "cells", "getCells", "The cells that meet a box", mesh, asks(About::cells),
                         {bbox, cell_format, limit}));
  Route cells = route("POST", "cells", "getCellsOfPolygon", "The cells that meet polygons", mesh,
                      asks_with_body(About::cells, {geojson_type, json}), {cell_format, limit});
  cells.body = "Document";
  cells.body_types = {geojson_type};
  routes.push_back(std::move(cells));
  Route interpolate =
      route("POST", "interpolate", "interpolate", "Interpolate an attribute of the vertices at points", many,
            asks_with_body(About::interpolate, {json, csv, npy, protobuf_type, bytes}),
            {{"value", "string", "The attribute of the vertices to interpolate; default in 2D: z, the heights"},
             {"method", "string", "The method of interpolation: linear or natural (natural neighbours)"},
             {"weights", "boolean", "Also give the vertices of which a value is made, with their weights"},
             answer_format});
  interpolate.body = "Points";
  interpolate.body_types = {csv, npy, protobuf_type};
  routes.push_back(std::move(interpolate));
  routes.push_back(route("GET", "dem", "getDem", "The surface of a 2D result as a raster",
                         {{200, tiff, "", "The raster"}}, asks(About::dem),
                         {bbox,
                          {"res", "number", "The width and height of a pixel, in units of the coordinates"},
                          {"max-edge", "number", "Draw no pixels in cells with a longer edge"},
                          {"max-radius", "number", "Draw no pixels in cells with a larger circumradius"},
                          {"value", "string", "The attribute of the vertices; default: z, the heights"},
                          {"method", "string", "The method of interpolation: linear (default), natural or laplace"},
                          {"type", "string", "The type of the pixels: float32 (default) or float64"}}));
  const Parameter max_edge{"max-edge", "number", "Leave out cells with a longer edge"};
  const Parameter max_radius{"max-radius", "number", "Leave out cells with a larger circumradius"};
  const Parameter value{"value", "string", "The attribute of the vertices; default: z, the heights"};
  routes.push_back(
      route("GET", "contours", "getContours", "The contour lines of a 2D result",
            {{200, geojson_type, "", "The lines, in the coordinates of the result"},
             {200, "application/geopackage+sqlite3", "", "The lines, as a GeoPackage"}},
            asks(About::contours),
            {bbox,
             {"interval", "number", "The distance between levels, in units of the heights"},
             {"base", "number", "The height of one of the levels; default: 0"},
             max_edge,
             max_radius,
             value,
             {"smooth", "number", "Draw lines of a smooth surface, the means of the surface in squares of this size"},
             {"min-length", "number", "Leave out lines that are shorter in the plane"},
             {"index-every", "integer", "Every N-th level, from base on, is an index line; default: 5"},
             {"f", "string", "The format of the lines: geojson or gpkg"}}));
  const std::vector<Response> heights{
      {200, csv, "", "The profile, with a row for each place where it bends"},
      {200, json, "Profile", "The profile, with a point for each place where it bends"},
      {200, geojson_type, "", "The profile as lines, with the value as the third coordinate"}};
  const Parameter digits{"digits", "string",
                         "csv: the number of decimals, 0 to 17, or all; default: as many as the data have"};
  const Parameter profile_format{
      "f", "string", "The format of the profile: csv, json or geojson; default: the format in Accept, or csv"};
  routes.push_back(route("GET", "profile", "getProfile", "The heights of a 2D result along a line", heights,
                         asks(About::profile),
                         {{"line", "string", "The line, by its points: x,y x,y ..."},
                          max_edge,
                          max_radius,
                          value,
                          digits,
                          profile_format}));
  Route profile = route("POST", "profile", "getProfileOfLine", "The heights of a 2D result along a line", heights,
                        asks_with_body(About::profile, {geojson_type, json}),
                        {max_edge, max_radius, value, digits, profile_format});
  profile.body = "Document";
  profile.body_types = {geojson_type};
  routes.push_back(std::move(profile));

  const std::string place = "x,y,z";
  const std::vector<Response> shape{{200, gltf, "", "Binary glTF, quantised and compressed; each cell is separate"}};
  routes.push_back(route("GET", "shapes/hull", "getHull",
                         "A model to view: the hull of a 3D result, or the border of its cells without long edges",
                         shape, asks(About::hull), {max_edge, max_radius, limit}));
  routes.push_back(route("GET", "shapes/section", "getSection",
                         "A model to view: the section of a 3D result by a plane", shape, asks(About::section),
                         {{"through", "string", "A point of the plane: " + place},
                          {"normal", "string", "The normal of the plane: " + place},
                          bbox,
                          max_edge,
                          max_radius,
                          limit}));
  routes.push_back(route(
      "GET", "shapes/cells", "getSolids", "A model to view: the tetrahedra that meet a box", shape, asks(About::solids),
      {bbox,
       {"shrink", "number",
        "The size of each tetrahedron, shrunk towards its centre, from 0.01 to 1; default: 1, its full size"},
       max_edge,
       max_radius,
       limit}));
}

}  // namespace tessera::service::http
