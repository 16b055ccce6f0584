// What every exporter tells of its process, under the names that Prometheus gives them.
#pragma once

#include <cstdint>

namespace tessera::http {

struct ProcessFigures {
  double start_time_s = 0;  // since 1970
  double cpu_s = 0;         // of processors, since the start
  std::uint64_t resident_bytes = 0, virtual_bytes = 0;
  std::uint64_t open_files = 0, open_files_max = 0, threads = 0;
};

// Of this process. What the system does not tell is 0.
ProcessFigures process_figures();

}  // namespace tessera::http
