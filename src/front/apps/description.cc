#include "src/front/apps/description.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <nlohmann/json.hpp>

#include "src/base/json/json_text.h"
#include "src/front/apps/completion.h"

namespace tessera::apps {
namespace {

using Json = nlohmann::ordered_json;

Json description_of(const Command& command, const CLI::Option& option) {
  Json described = {{"name", option.get_positional() ? option.get_name() : option.get_lnames().front()}};
  if (!option.get_snames().empty()) described["short"] = option.get_snames().front();
  described["value"] = option.get_type_name();  // "": a switch
  described["many"] = option.get_expected_max() == CLI::detail::expected_max_vector_size;
  described["choices"] = choices_of(command, option);
  described["help"] = option.get_description();
  return described;
}

Json description_of(const Command& command) {
  const CLI::App& app = *command.app;
  Json arguments = Json::array(), options = Json::array();
  for (const auto* option : app.get_options()) {
    if (option->get_group().empty() || option == app.get_help_ptr()) continue;
    (option->get_positional() ? arguments : options).push_back(description_of(command, *option));
  }
  return {{"name", app.get_name()}, {"group", app.get_group()}, {"about", app.get_description()},
          {"arguments", arguments}, {"options", options},       {"footer", app.get_footer()}};
}

}  // namespace

std::string description_of(const std::vector<Command>& commands) {
  Json all = Json::array();
  for (const auto& command : commands) all.push_back(description_of(command));
  return json_text(all, 1) + "\n";
}

}  // namespace tessera::apps
