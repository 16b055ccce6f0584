// JSON values to text and back. nlohmann's writer and parser are templates. Compiled here once, they save each source
// file that calls them a second or more.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace tessera {

// Returns the JSON text of a value; with `indent` below 0 on one line. Bytes that are not UTF-8 become U+FFFD.
std::string json_text(const nlohmann::json& value, int indent = -1);
std::string json_text(const nlohmann::ordered_json& value, int indent = -1);

// Parses JSON. The result of a text that is not JSON has is_discarded(). Call nested_too_deep() first for foreign
// texts.
nlohmann::json parse_json(std::string_view text);
nlohmann::ordered_json parse_ordered_json(std::string_view text);

}  // namespace tessera
