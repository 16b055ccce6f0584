#include "src/front/apps/remote_inputs.h"

#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>
#include <system_error>
#include <utility>

#include "src/base/files/there.h"
#include "src/job/arguments.h"

namespace tessera::apps {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using Json = nlohmann::ordered_json;
using Type = FieldDescriptor::CppType;

// The options that have another name at the daemon.
const std::map<std::string, std::string> other_names{
    {"index", "spatial_index"}, {"max-points-per-tile", "tile_points"}, {"z", "heights"}};

const FieldDescriptor* field_of(const Descriptor& inputs, std::string key) {
  if (const auto other = other_names.find(key); other != other_names.end()) {
    if (const auto* field = inputs.FindFieldByName(other->second)) return field;
  }
  std::replace(key.begin(), key.end(), '-', '_');
  return inputs.FindFieldByName(key);
}

Result<Json> count_json(const std::string& text, std::uint64_t highest) {
  BOOST_OUTCOME_TRY(count, parse_count(text));
  if (count > highest) return error(Errc::usage, "'" + text + "' is too large");
  return Json(count);
}

Result<Json> value_json(const std::string& text, const FieldDescriptor& field) {
  switch (field.cpp_type()) {
    case Type::CPPTYPE_BOOL: {
      BOOST_OUTCOME_TRY(on, parse_switch(text));
      return Json(on);
    }
    case Type::CPPTYPE_INT32:
    case Type::CPPTYPE_INT64:
      return count_json(text, std::numeric_limits<std::int32_t>::max());
    case Type::CPPTYPE_UINT32:
      return count_json(text, std::numeric_limits<std::uint32_t>::max());
    case Type::CPPTYPE_UINT64:
      return count_json(text, std::numeric_limits<std::uint64_t>::max());
    case Type::CPPTYPE_FLOAT:
    case Type::CPPTYPE_DOUBLE: {
      BOOST_OUTCOME_TRY(number, parse_finite(text));
      return Json(number);
    }
    default:
      return Json(text);
  }
}

Result<Json> json_of(const std::string& text, const FieldDescriptor& field) {
  if (!field.is_repeated()) return value_json(text, field);
  BOOST_OUTCOME_TRY(names, parse_names(text));
  Json list = Json::array();
  for (const auto& name : names) {
    BOOST_OUTCOME_TRY(value, value_json(name, field));
    list.push_back(value);
  }
  return list;
}

}  // namespace

std::vector<std::string> only_here(std::vector<std::string> more) {
  std::vector<std::string> keys{"config", "output", "quiet",      "verbose", "json",    "detach",
                                "server", "token",  "token-file", "ca",      "patience"};
  keys.insert(keys.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
  return keys;
}

Error in_flags(Error refused) {
  constexpr std::string_view field = "overwrite: true";
  if (const auto at = refused.where.find(field); at != std::string::npos)
    refused.where.replace(at, field.size(), "--overwrite");
  return refused;
}

Error advise_upload(Error refused, const std::vector<std::string>& inputs) {
  refused = in_flags(std::move(refused));
  if (!refused.where.starts_with("inputs:")) return refused;
  for (const auto& input : inputs) {
    const auto here = is_regular(input);  // an error here means only that there is no advice
    if (!here || !here.value()) continue;
    refused.where += "; " + input + " is a file here, which 'tessera upload' sends to the daemon";
    break;
  }
  return refused;
}

Error advise_here(Error refused, const std::string& name) {
  refused = in_flags(std::move(refused));
  if (refused.code != Errc::usage || !refused.where.starts_with("triangulation:")) return refused;
  if (const auto here = is_folder(name); here && here.value())
    refused.where += "; " + name + " is a folder here: with --server '' the command works on it";
  return refused;
}

std::string without_slash(std::string name) {
  while (name.size() > 1 && name.ends_with('/')) name.pop_back();
  return name;
}

Result<Json> remote_inputs(const Settings& settings, const Descriptor& inputs, const std::vector<std::string>& here) {
  Json json = Json::object();
  for (const auto& key : settings.given()) {
    if (std::find(here.begin(), here.end(), key) != here.end() || settings.text(key) == "auto") continue;
    const auto* field = field_of(inputs, key);
    if (field == nullptr) {
      if (settings.source(key) == Settings::Source::environment)
        continue;  // a variable may be meant for other commands
      return error(Errc::usage, "--" + key + " is not for a job of a daemon");
    }
    BOOST_OUTCOME_TRY(value, settings.get(key, [&](const std::string& text) { return json_of(text, *field); }));
    json[field->name()] = *value;
  }
  return json;
}

}  // namespace tessera::apps
