// Messages to systemd, or to another supervisor that uses its protocol (sd_notify(3)). They do nothing without one.
#pragma once

#include <chrono>
#include <optional>
#include <string>

namespace tessera::daemon::supervisor {

void ready(const std::string& status);
void reloading();
void stopping();
void alive();
// Returns the longest time between two calls of alive() that the supervisor accepts; no value if it expects no calls.
std::optional<std::chrono::microseconds> watchdog();

}  // namespace tessera::daemon::supervisor
