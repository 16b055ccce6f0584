// The command that writes alpha shapes.
#pragma once

#include "src/front/apps/command.h"

namespace tessera::apps {

Command add_alpha(CLI::App& root);

}  // namespace tessera::apps
