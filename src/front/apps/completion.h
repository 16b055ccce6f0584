// Shell completion, made from the declarations of the commands.
#pragma once

#include <string>
#include <vector>

#include "src/front/apps/command.h"

namespace tessera::apps {

// Returns a script for bash, and for zsh after `autoload -U bashcompinit && bashcompinit`. The script completes
// commands, options, and the values of options that have few. Elsewhere the shell offers names of files.
std::string completion(const std::vector<Command>& commands);

}  // namespace tessera::apps
