// Makes JSON schemas (those of OpenAPI 3.0) of the messages of proto/service.proto from their descriptors.
#pragma once

#include <google/protobuf/descriptor.h>

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace tessera::service::http {

// A field's name in JSON.
std::string json_name(const google::protobuf::FieldDescriptor& field);
// The schema of one value, or of a list for a repeated field. Messages are references.
nlohmann::ordered_json field_schema(const google::protobuf::FieldDescriptor& field);
// By message: the JSON names of the fields that are always set, which protobuf does not tell.
const std::map<std::string, std::vector<std::string>>& required_fields();
// The schemas of all messages of the file, by name.
nlohmann::ordered_json message_schemas();
// True if the schema is also a message of this name in proto/service.proto or proto/query.proto.
bool is_message(const std::string& schema);

}  // namespace tessera::service::http
