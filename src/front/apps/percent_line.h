// How much of something is done, on one line of the terminal.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "src/front/apps/command.h"

namespace tessera {

// "fetching 12 % of 3.4 GiB", drawn again when the percentage changes; nothing where nobody looks. `what`: "fetching".
std::function<void(std::uint64_t bytes, std::uint64_t total)> percent_line(const std::string& what,
                                                                           const OutputOptions& output);
// The same for parts of a whole, 0..1: "drawing 12 %"; null where nobody looks.
std::function<void(double)> share_line(const std::string& what, const OutputOptions& output);
// Takes it away.
void clear_line(const OutputOptions& output);

}  // namespace tessera
