// Converts the parts of a manifest to JSON and back. Functions that read throw nlohmann's exceptions, which
// read_manifest() catches.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "src/base/attribute.h"
#include "src/result/store/tile_store.h"

namespace tessera::store {

// Infinity becomes a text, because JSON has no infinity. Finite doubles get as many digits as are needed to read the
// same double back.
nlohmann::ordered_json number(double value);
double to_double(const nlohmann::json& value);
// Accepts non-negative integers only; get<unsigned>() would accept -1 and 1.5.
std::uint64_t to_count(const nlohmann::json& value);
std::uint64_t to_sum(const nlohmann::json& value);
const char* name_of(AttributeType type);
AttributeType to_type(const nlohmann::json& value);  // its member "type"
std::string to_name(const nlohmann::json& value);    // its member "name"

// The members that only changed results have: the version, and the columns, which must agree with the schema that was
// read before.
void write_versions(const Manifest& manifest, nlohmann::ordered_json& value);
void read_versions(const nlohmann::json& value, Manifest& manifest);

}  // namespace tessera::store
