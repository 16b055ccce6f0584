// JSON schemas (as OpenAPI 3.0 has them) of the messages of proto/service.proto, made from their descriptors.
#pragma once

#include <google/protobuf/descriptor.h>

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace tessera::http {

// A field's name in JSON.
std::string json_name(const google::protobuf::FieldDescriptor& field);
// Of one value, of a list of them for a repeated field. Messages are references.
nlohmann::ordered_json field_schema(const google::protobuf::FieldDescriptor& field);
// By message: the fields that it always has, by their names there. Protobuf itself does not say.
const std::map<std::string, std::vector<std::string>>& required_fields();
// Of every message of the file, under its name.
nlohmann::ordered_json message_schemas();
// Whether what this schema says may also be a message: one of that name, in proto/service.proto or proto/query.proto.
bool is_message(const std::string& schema);

}  // namespace tessera::http
