// Shell completion, made from the declarations of the commands.
#pragma once

#include <string>
#include <vector>

#include "src/front/apps/command.h"

namespace CLI {
class Option;
}

namespace tessera::apps {

// Returns the values that an option or argument can have; none if any value is possible.
std::vector<std::string> choices_of(const Command& command, const CLI::Option& option);
// Returns a script for bash, and for zsh after `autoload -U bashcompinit && bashcompinit`. The script completes
// commands, options, and the values of options that have few. Elsewhere the shell offers names of files.
std::string completion(const std::vector<Command>& commands);

}  // namespace tessera::apps
