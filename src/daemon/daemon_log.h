// The daemon's log, on stderr: text, or one JSON object a line.
#pragma once

namespace tessera {

// `insecure`: every line says so.
void start_daemon_log(bool json, bool insecure);

}  // namespace tessera
