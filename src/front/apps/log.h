// The log of the command, on stderr: warnings always, other messages with -v. Keeps spdlog out of headers.
#pragma once

#include <string>

namespace tessera::apps {

void start_log();       // must be called once, before all others
void log_everything();  // for -v
void log_debug(const std::string& message);

}  // namespace tessera::apps
