// The commands as data, for programs that offer them: the plugin of QGIS, and the reference among the documents.
#pragma once

#include <string>
#include <vector>

#include "src/front/apps/command.h"

namespace tessera::apps {

// Returns a JSON array with an object for each command: its name, group, what it does, arguments, options, and what the
// help says at its end. All words are those of the declarations.
std::string description_of(const std::vector<Command>& commands);

}  // namespace tessera::apps
