// Adds an option of `tesserad`: a flag, a variable, and a key of the configuration file, all with the same name.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "src/front/apps/settings.h"

namespace tessera::daemon {

inline void add_option(CLI::App& app, apps::Settings& settings, const std::string& key, const std::string& metavar,
                       const std::string& help) {
  settings.declare(key);
  app.add_option_function<std::string>(
         "--" + key, [&settings, key](const std::string& text) { settings.set_flag(key, text); }, help)
      ->type_name(metavar);
}

// An option of several words, which may be given several times.
inline void add_list(CLI::App& app, apps::Settings& settings, const std::string& key, const std::string& metavar,
                     const std::string& help) {
  settings.declare(key);
  app.add_option_function<std::vector<std::string>>(
         "--" + key,
         [&settings, key](const std::vector<std::string>& words) {
           std::string text;
           for (const std::string& word : words) text += (text.empty() ? "" : ",") + word;
           settings.set_flag(key, text);
         },
         help)
      ->type_name(metavar)
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

inline void add_switch(CLI::App& app, apps::Settings& settings, const std::string& key, const std::string& help) {
  settings.declare(key);
  app.add_flag_callback(
      "--" + key, [&settings, key] { settings.set_flag(key, "true"); }, help);
}

}  // namespace tessera::daemon
