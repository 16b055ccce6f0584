// JSON values to text and back, compiled once: nlohmann's writer and parser are templates that take a second a source.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace tessera {

// `indent` below 0: all on one line. Bytes that are not UTF-8 become U+FFFD.
std::string json_text(const nlohmann::json& value, int indent = -1);
std::string json_text(const nlohmann::ordered_json& value, int indent = -1);

// Of text that is no JSON, a value for which is_discarded() holds. Text of strangers: nested_too_deep() comes first.
nlohmann::json parse_json(std::string_view text);
nlohmann::ordered_json parse_ordered_json(std::string_view text);

}  // namespace tessera
