// What the command says of itself.
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

namespace tessera {

// Help without the negations of switches, which it would show as "Excludes:".
std::shared_ptr<CLI::FormatterBase> help_formatter();

// Which of `names` was meant: one that `word` begins, or that at most a third of its letters separate from it (a letter
// more, less, other, or two exchanged).
std::optional<std::string> nearest(std::string_view word, const std::vector<std::string>& names);

// The arguments after the program's name, `help` and `help COMMAND` turned into --help. Error usage, naming the
// nearest, when the first is no option and none of `commands`.
Result<std::vector<std::string>> resolve_command(std::vector<std::string> arguments,
                                                 const std::vector<std::string>& commands);

// What is wrong with arguments that `app` could not take, in a sentence of ours that names the option, its value or the
// nearest option. `name`: as the user calls it, "tessera dem".
std::string wrong_arguments(const CLI::App& app, const std::string& name, const CLI::ParseError& wrong);

}  // namespace tessera
