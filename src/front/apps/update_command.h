// The command that changes results, and the command that lists what has changed them.
#pragma once

#include "src/front/apps/command.h"

namespace tessera::apps {

Command add_update(CLI::App& root);
Command add_log(CLI::App& root);

}  // namespace tessera::apps
