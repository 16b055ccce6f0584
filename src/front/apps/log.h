// spdlog on stderr, kept out of the headers. Warnings always, the rest with -v.
#pragma once

#include <string>

namespace tessera {

void start_log();       // once, first of all
void log_everything();  // -v
void log_debug(const std::string& message);

}  // namespace tessera
