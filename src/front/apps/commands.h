// All commands of the program, to run them or to describe them.
#pragma once

#include <vector>

#include "src/front/apps/command.h"

namespace tessera::apps {

// Declares all commands, and the texts of the program's help, in a new `root`, which must outlive the commands.
std::vector<Command> add_commands(CLI::App& root);

}  // namespace tessera::apps
