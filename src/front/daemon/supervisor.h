// What systemd, or another supervisor that speaks its protocol, is told (sd_notify(3)). Without one nothing happens.
#pragma once

#include <chrono>
#include <optional>
#include <string>

namespace tessera::supervisor {

void ready(const std::string& status);
void reloading();
void stopping();
void alive();
// How often alive() is expected at least; nothing when nobody waits for it.
std::optional<std::chrono::microseconds> watchdog();

}  // namespace tessera::supervisor
