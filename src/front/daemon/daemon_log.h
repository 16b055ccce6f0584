// The daemon's log, on stderr: text, or one JSON object a line.
#pragma once

namespace tessera::daemon {

inline constexpr const char* daemon_log_name = "tesserad";

// Must be called once, before the first line. `insecure`: every line says that the daemon is insecure.
void start_daemon_log(bool json, bool insecure);

}  // namespace tessera::daemon
