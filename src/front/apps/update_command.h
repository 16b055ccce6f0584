// The command that changes results.
#pragma once

#include "src/front/apps/command.h"

namespace tessera::apps {

Command add_update(CLI::App& root);

}  // namespace tessera::apps
