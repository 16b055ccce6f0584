#include "src/service/http/processes.h"

#include <algorithm>
#include <string>
#include <utility>

#include "src/base/json/json_text.h"
#include "src/service/http/schema.h"
#include "src/service/json.h"
#include "src/service/processes/helps.h"
#include "src/service/processes/table.h"
#include "src/service/questions/questions_backend.h"

namespace tessera::service::http {
namespace {

using nlohmann::ordered_json;

constexpr const char* version = "1.0.0";

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
