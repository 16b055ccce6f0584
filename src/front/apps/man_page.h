// Manual pages, made from the declarations of the commands. See man-pages(7) for the sections, groff_man(7) for the
// markup.
#pragma once

#include <string>
#include <vector>

#include "src/front/apps/command.h"

namespace tessera::apps {

std::string man_page_of_program(const CLI::App& root, const std::vector<Command>& commands);  // tessera(1)
std::string man_page(const Command& command);                                                 // tessera-NAME(1)

// Returns the text escaped for roff: no character is markup, and hyphens are those that can be copied into a shell.
std::string roff(const std::string& text);

}  // namespace tessera::apps
