#include "src/service/http/processes.h"

#include <algorithm>
#include <iterator>
#include <string>
#include <utility>

#include "src/base/json/json_text.h"
#include "src/service/http/schema.h"
#include "src/service/json.h"
#include "src/service/processes/table.h"
#include "src/service/questions/questions_backend.h"

namespace tessera::service::http {
namespace {

using nlohmann::ordered_json;

constexpr const char* version = "1.0.0";

// What the inputs of all processes mean, by name: equal names mean the same.
constexpr std::pair<const char*, const char*> helps[] = {
    {"inputs", "Files, folders or patterns below the folders that the service has for inputs, or upload:NAME/FILE."},
    {"output", "The name of the result or file that the job makes; default: the service chooses one."},
    {"dim",
     "The dimension of the triangulation, 2 (x and y alone) or 3; default: 3, or 2 when the files hold x and y "
     "alone."},
    {"tiles", "The number of tiles; default: chosen from memory and threads."},
    {"tile_points", "How many points a tile may hold at most; default: chosen from memory and threads."},
    {"partition", "How space is split into tiles: kdtree (default), grid, octree, or random, which is for tests."},
    {"threads", "How many threads the job may use."},
    {"memory", "How much memory the job may use: a number with K, M, G or T."},
    {"kernel", "The Delaunay kernel, which triangulates each tile: flat (default) or cgal."},
    {"store",
     "What the result stores of its tiles: cells; points, which takes a tenth of the bytes; or auto (default), which "
     "stores points for clouds of more than 50 million points."},
    {"neighbors", "Also store the neighbours of each cell; without them the files are half as large."},
    {"crop", "Keep only points in this box: the coordinates of its lower corner, then of its upper corner."},
    {"class", "Keep only points of these LAS classes."},
    {"attributes", "The attributes of the points that the result carries, by name; all means all of them."},
    {"resolution",
     "COPC files: read only the octree levels down to the first whose points are at most this far apart; default: "
     "all levels."},
    {"columns",
     "Text and NumPy files: the names of the columns, in order: x, y, z, the name of an attribute, or _ for a column "
     "to leave out."},
    {"crs", "The coordinate system of all input files, whatever the files say: EPSG:n or WKT."},
    {"returns", "LAS files: keep all returns of each pulse (default), or only the first, last or single one."},
    {"without", "LAS files: leave out points with one of these flags."},
    {"recursive", "Also take the files in subfolders of input folders."},
    {"overwrite", "Replace a result or file that already has the name of the output."},
    {"keep",
     "2D: which of several points with equal x and y becomes the vertex: the first (default), last, lowest or "
     "highest."},
    {"heights",
     "2D: keep the heights: a result carries them as the attribute z, and files have them as the third coordinate."},
    {"skip_invalid", "Leave out points with NaN or infinite coordinates and count them, instead of refusing the file."},
    {"triangulation", "The name of a result."},
    {"against_cgal", "Also compare the result with a triangulation that CGAL computes in memory."},
    {"format", "The format of the file; default: the format of the ending of output."},
    {"local",
     "ply, obj, off, stl: write coordinates relative to the lower corner of the result's box, for programs that keep "
     "them as floats."},
    {"spatial_index", "GeoPackage: also write a spatial index of the cells."},
    {"max_edge", "Leave out cells with a longer edge."},
    {"stats", "Also read all points, and give statistics of them."},
    {"bbox", "Only what is in this box: the coordinates of its lower corner, then of its upper corner."},
    {"polygon", "The region, as text: polygons in GeoJSON, in the coordinates of the points."},
    {"max_points", "Triangulate at most this many points; default: as many as the memory allows."},
    {"max_seconds", "Give up after about this many seconds; default: never."},
    {"partial",
     "When max_points, max_seconds or the memory is used up, store the cells that are known, instead of failing."},
    {"scan",
     "Read all files once to see where their points are, instead of relying on the boxes that the files state."},
    {"res", "The width and height of a pixel, in units of the coordinates."},
    {"value", "The attribute of the vertices to draw; default: z, the heights."},
    {"method",
     "How values follow from the vertices: linear in each cell (default), natural (Sibson's natural neighbours), or "
     "laplace (natural neighbours, with other weights)."},
    {"type", "The type of the pixels: float32 (default) or float64."},
    {"hillshade", "Draw a hillshade of the surface instead of the heights."},
    {"azimuth", "hillshade: the direction of the light, in degrees clockwise from north; default: 315."},
    {"altitude", "hillshade: the height of the light above the horizon, in degrees; default: 45."},
    {"interval", "The distance between levels, in units of the heights."},
    {"base", "The height of one of the levels; default: 0."},
    {"smooth",
     "Draw lines of a smooth surface, the means of the surface in squares of this size; default: lines of the "
     "surface itself."},
    {"min_length", "Leave out lines that are shorter in the plane; default: keep all lines."},
    {"sensor",
     "Where the sensor was that saw the points: auto (default: the best that the points tell), vertical (straight "
     "above), fields (attributes of the points), scan-angle, or point:X,Y,Z;..."},
    {"lambda", "How much the quality of triangles counts; a larger number makes a smoother surface; default: 1."},
    {"alpha", "How much a ray, the line from a point to its sensor, counts; default: 32."},
    {"sigma",
     "How far a point may be from the surface, in units of the coordinates; default: for each point from the length "
     "of its edges."},
    {"ray_length", "How far a ray goes towards its sensor, as a multiple of sigma; full: all the way; default: 100."},
    {"bottom",
     "What is below all points: closed (default): inside, and the surface has a bottom; open: inside, but the "
     "surface has no bottom; free: outside."},
    {"unknown", "What a place is that no ray has seen: solid (default) or empty."},
    {"trim", "Leave out triangles with a longer edge; the surface is then not closed."},
    {"manifold",
     "Split vertices and edges where the surface touches itself, for programs that need a manifold; no vertex "
     "moves."},
    {"smoothing", "How many rounds of smoothing, which move the vertices; default: 0."},
    {"index_every", "Every N-th level, from base on, is an index line; default: 5."}};

const char* help_of(const std::string& field) {
  const auto help =
      std::find_if(std::begin(helps), std::end(helps), [&](const auto& each) { return field == each.first; });
  return help == std::end(helps) ? nullptr : help->second;
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
    if (!execute.ParseFromString(request.body))
      return error(Errc::usage, "the body is not a protobuf message tessera.proto.Execute");
    if (!execute.inputs().GetReflection()->HasField(execute.inputs(), &member_of(process)))
      return error(Errc::usage, std::string("inputs: must be the inputs of the process ") + process.name);
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
