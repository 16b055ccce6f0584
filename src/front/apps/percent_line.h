// A line on the terminal that shows how much is done; with --json, events that tell it.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "src/front/apps/command.h"

namespace tessera::apps {

// Returns a function that draws "fetching 12 % of 3.4 GiB", and draws it again when the percentage changes. The
// function does nothing if stderr is no terminal, or `output` forbids it. With --json it prints events of progress to
// stdout instead, from one second on. `what`: "fetching".
std::function<void(std::uint64_t bytes, std::uint64_t total)> percent_line(const std::string& what,
                                                                           const OutputOptions& output);
// Returns the same for fractions, 0 to 1: "drawing 12 %"; null if nothing would be drawn.
std::function<void(double)> share_line(const std::string& what, const OutputOptions& output);
// Removes the line.
void clear_line(const OutputOptions& output);

}  // namespace tessera::apps
