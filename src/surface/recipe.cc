#include "src/surface/recipe.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "src/base/json/json_text.h"

namespace tessera::surface {

namespace {

using Json = nlohmann::ordered_json;
using Bottom = SurfaceOptions::Bottom;

constexpr std::string_view begin = "surface ";

const char* name_of(Bottom bottom) {
  switch (bottom) {
    case Bottom::open:
      return "open";
    case Bottom::free:
      return "free";
    case Bottom::closed:
      break;
  }
  return "closed";
}

Bottom bottom_of(const std::string& name) {
  for (const Bottom bottom : {Bottom::closed, Bottom::open, Bottom::free})
    if (name == name_of(bottom)) return bottom;
  throw Json::other_error::create(501, "no bottom", nullptr);
}

Recipe recipe_in(const Json& json) {
  Recipe recipe{.triangulation = json.at("triangulation"), .sensors = json.at("sensor"), .options = {}};
  SurfaceOptions& options = recipe.options;
  json.at("lambda").get_to(options.energy.lambda);
  json.at("alpha").get_to(options.energy.alpha);
  json.at("sigma").get_to(options.energy.sigma);
  const Json& length = json.at("ray_length");
  options.energy.ray_length = length.is_null() ? std::numeric_limits<double>::infinity() : length.get<double>();
  options.bottom = bottom_of(json.at("bottom"));
  json.at("unknown_inside").get_to(options.unknown_inside);
  if (!json.at("trim").is_null()) options.trim = json.at("trim").get<double>();
  json.at("manifold").get_to(options.manifold);
  json.at("smooth").get_to(options.smooth);
  json.at("local").get_to(options.output.local);
  return recipe;
}

}  // namespace

std::string recipe_of(const SurfaceOptions& options, const Manifest& manifest) {
  const Json json{{"triangulation", manifest.digest ? digest_text(*manifest.digest) : ""},
                  {"sensor", options.sensors.text},
                  {"lambda", options.energy.lambda},
                  {"alpha", options.energy.alpha},
                  {"sigma", options.energy.sigma},
                  {"ray_length", options.energy.ray_length},  // null when it is infinite
                  {"bottom", name_of(options.bottom)},
                  {"unknown_inside", options.unknown_inside},
                  {"trim", options.trim ? Json(*options.trim) : Json()},
                  {"manifold", options.manifold},
                  {"smooth", options.smooth},
                  {"local", options.output.local}};
  return std::string(begin) + json.dump(-1, ' ', true, Json::error_handler_t::replace);
}

Result<std::optional<Recipe>> read_recipe(std::string_view line) {
  if (!line.starts_with(begin)) return std::optional<Recipe>();
  try {
    return std::optional(recipe_in(parse_ordered_json(line.substr(begin.size()))));
  } catch (const Json::exception&) {
    return error(Errc::bad_input, "its comment on how the surface was made cannot be understood");
  }
}

}  // namespace tessera::surface
