// How much of this machine a command takes: --memory and --threads.
#pragma once

#include <cstdint>
#include <string>

#include "src/base/result.h"
#include "src/front/apps/command.h"
#include "src/front/apps/settings.h"

namespace tessera {

// `of`: what the memory is for, as "tiles and lines".
void add_memory_option(Command& command, const std::string& of);
void add_threads_option(Command& command);

// What is given; for "auto" and 0, and when nothing is, the machine's default. Error usage.
Result<std::uint64_t> memory_option(const Settings& settings);
Result<std::uint32_t> threads_option(const Settings& settings);

}  // namespace tessera
