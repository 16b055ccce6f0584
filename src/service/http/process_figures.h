// Figures that exporters report of their process, under Prometheus's usual names.
#pragma once

#include <cstdint>

namespace tessera::service::http {

struct ProcessFigures {
  double start_time_s = 0;  // since 1970
  double cpu_s = 0;         // of all processors, since the start
  std::uint64_t resident_bytes = 0, virtual_bytes = 0;
  std::uint64_t open_files = 0, open_files_max = 0, threads = 0;
};

// The figures of this process; 0 for those that the system does not tell.
ProcessFigures process_figures();

}  // namespace tessera::service::http
