// JSON schemas of documents that are no messages: those of the standards, and what the commands print.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace tessera::service::http {

// A reference to the schema of the document.
nlohmann::ordered_json reference(const std::string& schema);
void add_documents(nlohmann::ordered_json& schemas);

}  // namespace tessera::service::http
