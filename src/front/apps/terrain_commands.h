// The commands that draw lines of a surface, contours and profile, and density, which fills a grid.
#pragma once

#include "src/front/apps/command.h"

namespace tessera::apps {

Command add_contours(CLI::App& root);
Command add_profile(CLI::App& root);
Command add_density(CLI::App& root);

}  // namespace tessera::apps
