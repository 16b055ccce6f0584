// The options --memory and --threads: how much of this machine a command uses.
#pragma once

#include <cstdint>
#include <string>

#include "src/base/result.h"
#include "src/front/apps/command.h"
#include "src/front/apps/settings.h"

namespace tessera::apps {

// `of`: what the memory is for, for example "tiles and lines".
void add_memory_option(Command& command, const std::string& of);
void add_threads_option(Command& command);

// These return the given value, or the machine's default if it is "auto", 0 or not given. Error usage.
Result<std::uint64_t> memory_option(const Settings& settings);
Result<std::uint32_t> threads_option(const Settings& settings);

}  // namespace tessera::apps
