// Completion for the shell, from the declarations of the commands.
#pragma once

#include <string>
#include <vector>

#include "src/front/apps/command.h"

namespace tessera {

// For bash; and for zsh, after `autoload -U bashcompinit && bashcompinit`. Completes commands, options, and the values
// of which there are few; elsewhere the shell offers names of files.
std::string completion(const std::vector<Command>& commands);

}  // namespace tessera
