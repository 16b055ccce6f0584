// The help of the command, and its messages for wrong command lines.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/result.h"

namespace CLI {
class App;
class FormatterBase;
class ParseError;
}  // namespace CLI

namespace tessera::apps {

// Returns a formatter of help texts that leaves out "Excludes:", which CLI11 would print for switches and their
// negations.
std::shared_ptr<CLI::FormatterBase> help_formatter();

// Returns the name that the user probably meant: one that begins with `word`, or else the nearest one, if at most a
// third of the letters differ (a letter added, left out or replaced, or two letters exchanged).
std::optional<std::string> nearest(std::string_view word, const std::vector<std::string>& names);

// Returns the arguments (those after the program's name), with `help` and `help COMMAND` turned into --help. Error
// usage, with the nearest command, if the first argument is neither an option nor one of `commands`.
Result<std::vector<std::string>> resolve_command(std::vector<std::string> arguments,
                                                 const std::vector<std::string>& commands);

// Returns a sentence about arguments that `app` could not parse. The sentence names the option, its value, or the
// nearest option. `name`: the command as the user types it, "tessera dem".
std::string wrong_arguments(const CLI::App& app, const std::string& name, const CLI::ParseError& wrong);

}  // namespace tessera::apps
