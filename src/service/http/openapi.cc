#include "src/service/http/openapi.h"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <nlohmann/json.hpp>

#include "src/base/json/json_text.h"
#include "src/service/http/documents.h"
#include "src/service/http/schema.h"
#include "src/service/http/tokens.h"

namespace tessera::service::http {
namespace {

using nlohmann::ordered_json;

// {path*} becomes {path}: the document cannot express that slashes are included.
std::string documented_path(std::string path) {
  path.erase(std::remove(path.begin(), path.end(), '*'), path.end());
  return path;
}

ordered_json parameters_of(const Route& route) {
  ordered_json parameters = ordered_json::array();
  const std::string path = documented_path(route.path);
  for (std::size_t open = path.find('{'); open != std::string::npos; open = path.find('{', open + 1)) {
    const std::string name = path.substr(open + 1, path.find('}', open) - open - 1);
    parameters.push_back({{"name", name}, {"in", "path"}, {"required", true}, {"schema", {{"type", "string"}}}});
  }
  for (const Parameter& parameter : route.query)
    parameters.push_back({{"name", parameter.name},
                          {"in", "query"},
                          {"required", false},
                          {"description", parameter.description},
                          {"schema", {{"type", parameter.type}}}});
  return parameters;
}

// A schema for content that is not JSON; of a message, with its name.
ordered_json bytes_of(const std::string& type, const std::string& schema = {}) {
  ordered_json told{{"type", "string"}, {"format", "binary"}};
  if (type == protobuf_type && is_message(schema)) told["description"] = "The message tessera.proto." + schema;
  return {{"schema", std::move(told)}};
}

ordered_json operation_of(const Route& route) {
  ordered_json operation{{"operationId", route.name},
                         {"summary", route.summary},
                         {"x-role", word_of(route.role)},
                         {"parameters", parameters_of(route)},
                         {"responses", ordered_json::object()}};
  if (!route.body.empty()) {
    ordered_json content;
    if (route.body == "bytes") {
      content["application/octet-stream"] = bytes_of("application/octet-stream");
    } else {
      content["application/json"] = {{"schema", reference(route.body)}};
      const std::vector<std::string> protobuf{protobuf_type};
      for (const std::string& type : route.body_types.empty() ? protobuf : route.body_types)
        content[type] = bytes_of(type, route.body);
    }
    operation["requestBody"] = {{"required", true}, {"content", std::move(content)}};
  }
  for (const Response& response : route.responses) {
    ordered_json& told = operation["responses"][std::to_string(response.status)];
    told["description"] = response.description;
    if (response.type.empty()) continue;
    ordered_json& content = told["content"];
    content[response.type] = {
        {"schema", response.schema.empty() ? ordered_json{{"type", "string"}} : reference(response.schema)}};
    if (is_message(response.schema)) content[protobuf_type] = bytes_of(protobuf_type, response.schema);
  }
  operation["responses"]["default"] = {{"$ref", "#/components/responses/Problem"}};
  if (route.role == Role::none) operation["security"] = ordered_json::array();
  if (route.role == Role::read)
    operation["security"] = {{{"token", ordered_json::array()}}, {{"password", ordered_json::array()}}};
  return operation;
}

}  // namespace

std::string openapi_document(const std::vector<Route>& routes, const std::string& server) {
  ordered_json document{{"openapi", "3.0.3"},
                        {"info",
                         {{"title", "Tessera"},
                          {"version", "1.0.0"},
                          {"description", "Exact Delaunay triangulations of large point clouds, as jobs."},
                          {"license", {{"name", "GPL-3.0-or-later"}}}}},
                        {"servers", {{{"url", server}}}},
                        {"security", {{{"token", ordered_json::array()}}}},
                        {"paths", ordered_json::object()}};
  ordered_json schemas = message_schemas();
  for (const Route& route : routes) {
    std::string method = route.method;
    std::transform(method.begin(), method.end(), method.begin(), [](unsigned char c) { return std::tolower(c); });
    document["paths"][documented_path(route.path)][method] = operation_of(route);
  }
  add_documents(schemas);
  ordered_json problem{{"description", "A problem document (RFC 9457)"}};
  problem["content"]["application/problem+json"] = {{"schema", reference("Problem")}};
  document["components"] = {
      {"schemas", std::move(schemas)},
      {"responses", {{"Problem", std::move(problem)}}},
      {"securitySchemes",
       {{"token", {{"type", "http"}, {"scheme", "bearer"}}},
        {"password",
         {{"type", "http"},
          {"scheme", "basic"},
          {"description", "Any user name, and the token as password; such requests may only read"}}}}}};
  return json_text(document);
}

}  // namespace tessera::service::http
