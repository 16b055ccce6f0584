// The commands of the program, for whoever runs or describes them.
#pragma once

#include <vector>

#include "src/front/apps/command.h"

namespace tessera {

// Declares all, and what the program says of itself, in this fresh `root`, which must outlive them.
std::vector<Command> add_commands(CLI::App& root);

}  // namespace tessera
