#include "src/service/http/schema.h"

#include <utility>

#include "query.pb.h"
#include "service.pb.h"

namespace tessera::service::http {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using nlohmann::ordered_json;

// The possible values where a type has more than are valid, by the field's name, which is the same in all processes.
ordered_json values_of(const FieldDescriptor& field) {
  static const std::map<std::string, ordered_json> inputs{
      {"dim", {2, 3}},
      {"partition", {"kdtree", "grid", "octree", "random"}},
      {"kernel", {"flat", "cgal"}},
      {"store", {"auto", "cells", "points"}},
      {"keep", {"first", "last", "lowest", "highest"}},
      {"returns", {"all", "first", "last", "single"}},
      {"type", {"float32", "float64"}},
      {"method", {"linear", "natural", "laplace"}},
      {"without", {"withheld", "synthetic", "overlap", "key_point"}}};
  static const std::map<std::string, ordered_json> others{
      {"tessera.proto.StatusInfo.status", {"accepted", "running", "successful", "failed", "dismissed"}},
      {"tessera.proto.NodeInfo.state", {"joining", "free", "draining"}},
      {"tessera.proto.CallerInfo.role", {"read", "submit", "admin"}}};
  const bool is_input = field.containing_type()->name().ends_with("Inputs");
  const auto& among = is_input ? inputs : others;
  const auto found = among.find(is_input ? field.name() : field.full_name());
  return found == among.end() ? ordered_json() : found->second;
}

ordered_json type_of(const FieldDescriptor& field) {
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_BOOL:
      return {{"type", "boolean"}};
    case FieldDescriptor::CPPTYPE_STRING:
      return {{"type", "string"}};
    case FieldDescriptor::CPPTYPE_INT32:
      return {{"type", "integer"}, {"format", "int32"}};
    case FieldDescriptor::CPPTYPE_INT64:
      return {{"type", "integer"}, {"format", "int64"}};
    case FieldDescriptor::CPPTYPE_UINT32:
      return {{"type", "integer"}, {"format", "int64"}, {"minimum", 0}};
    case FieldDescriptor::CPPTYPE_UINT64:
      return {{"type", "integer"}, {"minimum", 0}};
    case FieldDescriptor::CPPTYPE_FLOAT:
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return {{"type", "number"}};
    case FieldDescriptor::CPPTYPE_ENUM:
      return {{"type", "string"}};
    case FieldDescriptor::CPPTYPE_MESSAGE:
      return {{"$ref", "#/components/schemas/" + field.message_type()->name()}};
  }
  return ordered_json::object();
}

ordered_json value_schema(const FieldDescriptor& field) {
  ordered_json schema = type_of(field);
  ordered_json values = values_of(field);
  if (!values.is_null()) schema["enum"] = std::move(values);
  return schema;
}

ordered_json message_schema(const Descriptor& message) {
  ordered_json schema{{"type", "object"}, {"properties", ordered_json::object()}, {"additionalProperties", false}};
  const auto required = required_fields().find(message.name());
  if (required != required_fields().end()) schema["required"] = required->second;
  for (int at = 0; at < message.field_count(); ++at)
    schema["properties"][json_name(*message.field(at))] = field_schema(*message.field(at));
  return schema;
}

}  // namespace

const std::map<std::string, std::vector<std::string>>& required_fields() {
  static const std::map<std::string, std::vector<std::string>> fields{
      {"Link", {"href", "rel"}},
      {"Problem", {"type", "title", "status"}},
      {"StatusInfo", {"jobID", "id", "processID", "type", "status", "links"}},
      {"JobList", {"jobs", "links"}},
      {"TriangulationInfo", {"name", "links"}},
      {"TriangulationList", {"triangulations", "links"}},
      {"ExportInfo", {"name", "links"}},
      {"ExportList", {"exports", "links"}},
      {"InputInfo", {"name"}},
      {"InputList", {"inputs", "links"}},
      {"NodeInfo", {"name", "threads", "memoryBytes", "state", "coordinator"}},
      {"NodeList", {"nodes", "links"}},
      {"CallerInfo", {"name", "role"}},
      {"JobTiles", {"jobID", "begunAgain", "elapsed", "busyThreads", "busy"}},
      {"TileLayout", {"dimension", "bounds", "axis", "place", "below", "above"}},
      {"Execute", {"inputs"}},
      {"VerifyInputs", {"triangulation"}},
      {"ExportInputs", {"triangulation", "output"}},
      {"TriangulateInputs", {"inputs"}},
      {"RegionInputs", {"inputs"}},
      {"DemInputs", {"triangulation", "res"}},
      {"ContoursInputs", {"triangulation", "interval"}},
      {"SurfaceInputs", {"triangulation"}},
      {"HagInputs", {"inputs", "triangulation"}},
      {"MeasureInputs", {"triangulation"}},
      {"UpdateInputs", {"triangulation"}},
      {"VoronoiInputs", {"triangulation", "output"}},
      {"DensityInputs", {"triangulation", "output"}},
      {"AlphaInputs", {"triangulation", "output"}},
      {"VolumeInputs", {"triangulation", "output"}}};
  return fields;
}

std::string json_name(const FieldDescriptor& field) { return field.has_json_name() ? field.json_name() : field.name(); }

ordered_json field_schema(const FieldDescriptor& field) {
  if (!field.is_repeated()) return value_schema(field);
  return {{"type", "array"}, {"items", value_schema(field)}};
}

ordered_json message_schemas() {
  const google::protobuf::FileDescriptor& file = *proto::Problem::descriptor()->file();
  ordered_json schemas = ordered_json::object();
  for (int at = 0; at < file.message_type_count(); ++at)
    schemas[file.message_type(at)->name()] = message_schema(*file.message_type(at));
  return schemas;
}

bool is_message(const std::string& schema) {
  return proto::Problem::descriptor()->file()->FindMessageTypeByName(schema) ||
         proto::Points::descriptor()->file()->FindMessageTypeByName(schema);
}

}  // namespace tessera::service::http
