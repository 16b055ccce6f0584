#include "src/service/http/processes.h"

#include <algorithm>
#include <map>
#include <string>

#include "src/base/json/json_text.h"
#include "src/service/http/schema.h"
#include "src/service/json.h"
#include "src/service/processes/table.h"
#include "src/service/questions/questions_backend.h"

namespace tessera::service::http {
namespace {

using nlohmann::ordered_json;

constexpr const char* version = "1.0.0";

const char* help_of(const std::string& field) {
  static const std::map<std::string, const char*> texts{
      {"inputs", "Files, folders or patterns below the configured roots, or upload:NAME/FILE."},
      {"output", "The name of what is made; chosen when it is not given."},
      {"dim", "2 or 3: the dimension of the triangulation."},
      {"tiles", "How many tiles; chosen when it is not given."},
      {"tile_points", "How many points a tile holds at most."},
      {"partition", "How space is split into tiles."},
      {"threads", "How many threads the job may use."},
      {"memory", "How much memory the job may use: a number with K, M, G or T."},
      {"kernel", "Which Delaunay kernel."},
      {"store", "What is stored of tiles: cells, points that they follow from, or by the size of the cloud."},
      {"neighbors", "Also store the neighbours of each cell."},
      {"crop", "Only points in this box: the lower corner, then the upper one."},
      {"class", "Only points of these classes."},
      {"attributes", "Attributes of the points that are carried along."},
      {"resolution", "At most one point in a cube of this edge."},
      {"columns", "What the columns of text and NumPy files are called, in their order: x, y, z, attributes, or _."},
      {"crs", "The coordinate system of the points."},
      {"returns", "Only these returns of a pulse."},
      {"without", "Points with these flags are left out."},
      {"recursive", "Also files in folders below."},
      {"overwrite", "Replace what already has that name."},
      {"keep", "In two dimensions, which of the points of equal x and y becomes the vertex."},
      {"heights", "Keep the heights of a triangulation in two dimensions."},
      {"skip_invalid", "Points that cannot be read are counted and left out."},
      {"triangulation", "The name of a result."},
      {"against_cgal", "Also compare with CGAL."},
      {"format", "The format of the file; else its ending says."},
      {"local",
       "Coordinates that count from a corner of the result, for programs that keep floats; of ply, obj, off and stl."},
      {"spatial_index", "Also write a spatial index."},
      {"max_edge", "Cells with a longer edge are left out."},
      {"stats", "Also read the points, for their statistics."},
      {"bbox", "Only in this box: the lower corner, then the upper one."},
      {"polygon", "The region: polygons as text of GeoJSON, in the coordinates of the points."},
      {"max_points", "At most so many points are triangulated."},
      {"max_seconds", "Given up after about so many seconds."},
      {"partial", "Beyond these bounds the cells that are known, instead of a failure."},
      {"scan", "Read all files once and see where their points are, instead of believing them."},
      {"res", "The width of a pixel, in units of the coordinates."},
      {"value", "An attribute of the vertices; z, the heights, when it is not given."},
      {"type", "Of the pixels."},
      {"hillshade", "A hillshade of the surface instead."},
      {"azimuth", "Of the light, in degrees clockwise from north; 315 when it is not given."},
      {"altitude", "Of the light above the horizon, in degrees; 45 when it is not given."},
      {"interval", "The distance of levels, in units of the heights."},
      {"base", "A level; 0 when it is not given."},
      {"smooth", "Lines of a smooth surface: means of the surface in squares of this size."},
      {"min_length", "Lines that are shorter in the plane are left out."},
      {"sensor",
       "Where the light came from: auto (the best that the points tell), vertical, fields, scan-angle, or "
       "point:X,Y,Z;..."},
      {"lambda", "How much the quality of triangles counts: more is smoother; 1 when it is not given."},
      {"alpha", "How much a ray counts; 32 when it is not given."},
      {"sigma", "How far a point may be from the surface; each has its own when it is not given."},
      {"ray_length", "How many sigma a ray goes towards its sensor, or full; 100 when it is not given."},
      {"bottom", "Below all points: closed (inside, with a bottom), open (without one), or free (outside)."},
      {"unknown", "Where no ray tells: solid or empty."},
      {"trim", "Triangles with a longer edge are left out: the surface is not closed then."},
      {"manifold", "Where the surface touches itself, vertices and edges are split; nothing moves."},
      {"smoothing", "Rounds of smoothing, which move the vertices; none when it is not given."},
      {"index_every", "Every N-th level, from base on, is an index line; 5 when it is not given."}};
  const auto text = texts.find(field);
  return text == texts.end() ? nullptr : text->second;
}

const google::protobuf::Descriptor& inputs_of(const Process& process) { return *member_of(process).message_type(); }

bool is_required(const Process& process, const std::string& field) {
  const auto required = required_fields().find(inputs_of(process).name());
  if (required == required_fields().end()) return false;
  return std::find(required->second.begin(), required->second.end(), field) != required->second.end();
}

}  // namespace

ordered_json process_summary(const Process& process, const Links& links, const Request& request) {
  const std::string self = std::string("/v1/processes/") + process.name;
  ordered_json summary{{"id", process.name},
                       {"title", process.title},
                       {"description", process.description},
                       {"version", version},
                       {"jobControlOptions", process.waits ? ordered_json::array({"sync-execute", "async-execute"})
                                                           : ordered_json::array({"async-execute"})},
                       {"outputTransmission", ordered_json::array({process.waits ? "value" : "reference"})},
                       {"links", ordered_json::array()}};
  summary["links"].push_back({{"href", links.to(request, self)}, {"rel", "self"}, {"type", "application/json"}});
  summary["links"].push_back({{"href", links.to(request, self + "/execution")},
                              {"rel", "http://www.opengis.net/def/rel/ogc/1.0/execute"},
                              {"type", "application/json"}});
  if (process.estimated())
    summary["links"].push_back(
        {{"href", links.to(request, self + "/estimate")}, {"rel", "estimate"}, {"type", "application/json"}});
  return summary;
}

ordered_json process_description(const Process& process, const Links& links, const Request& request) {
  ordered_json description = process_summary(process, links, request);
  description["inputs"] = ordered_json::object();
  for (int at = 0; at < inputs_of(process).field_count(); ++at) {
    const google::protobuf::FieldDescriptor& field = *inputs_of(process).field(at);
    const std::string name = json_name(field);
    ordered_json input{{"title", name}};
    if (const char* help = help_of(name)) input["description"] = help;
    input["minOccurs"] = is_required(process, name) ? 1 : 0;
    input["maxOccurs"] = 1;
    input["schema"] = field_schema(field);
    description["inputs"][name] = std::move(input);
  }
  description["outputs"] = {{"result", {{"title", process.outcome}, {"schema", {{"type", "object"}}}}}};
  return description;
}

Result<proto::Inputs> read_inputs(const Process& process, const Request& request) {
  const std::string type = media_type(request.header("content-type"));
  proto::Execute execute;
  if (type == protobuf_type) {
    if (!execute.ParseFromString(request.body)) return error(Errc::usage, "the body is no Execute message");
    if (!execute.inputs().GetReflection()->HasField(execute.inputs(), &member_of(process)))
      return error(Errc::usage, std::string("inputs: must be those of ") + process.name);
    return execute.inputs();
  }
  // In JSON, the process in the address decides which inputs are meant.
  proto::Inputs inputs;
  google::protobuf::Message* chosen = inputs.GetReflection()->MutableMessage(&inputs, &member_of(process));
  if (nested_too_deep(request.body))
    return error(Errc::usage, "the body: lists and objects are nested more than 32 deep");
  const nlohmann::json body = parse_json(request.body);
  if (!body.is_object()) return error(Errc::usage, "the body must be a JSON object");
  for (const auto& [name, value] : body.items()) {
    if (name == "inputs") continue;
    // Requests that the standard allows, and that do not change the answer.
    if (name == "outputs" && value.is_object()) continue;
    if (name == "response" && value == "document") continue;
    return error(Errc::usage, as_utf8(name) + ": is not supported");
  }
  const auto found = body.find("inputs");
  if (found == body.end() || !found->is_object()) return error(Errc::usage, "inputs: must be an object");
  BOOST_OUTCOME_TRYV(from_json(found->dump(), *chosen));
  return inputs;
}

}  // namespace tessera::service::http
