// Manual pages, from the declarations of the commands: see man-pages(7) for their sections, groff_man(7) for the marks.
#pragma once

#include <string>
#include <vector>

#include "src/front/apps/command.h"

namespace tessera {

std::string man_page_of_program(const CLI::App& root, const std::vector<Command>& commands);  // tessera(1)
std::string man_page(const Command& command);                                                 // tessera-NAME(1)

// Text as roff prints it: no character of it is a mark, and hyphens are those that one can copy into a shell.
std::string roff(const std::string& text);

}  // namespace tessera
