#include "src/service/http/process_figures.h"

#include <sys/resource.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <fstream>
#include <sstream>
#include <string>

#include "src/base/files/folder.h"

namespace tessera::service::http {
namespace {

double seconds_of(const timeval& time) {
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) * 1e-6;
}

// Computed from the time since boot and the system's clock now. When the clock is set, the result changes.
double started_at(double ticks_after_boot) {
  timespec since_boot{};
  ::clock_gettime(CLOCK_BOOTTIME, &since_boot);
  const double age = static_cast<double>(since_boot.tv_sec) + static_cast<double>(since_boot.tv_nsec) * 1e-9 -
                     ticks_after_boot / static_cast<double>(::sysconf(_SC_CLK_TCK));
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count() - age;
}

}  // namespace

ProcessFigures process_figures() {
  ProcessFigures out;
  // "4711 (a name, which may hold anything) S 1 ...": the third field and those after it (proc(5)).
  std::ifstream told("/proc/self/stat");
  std::string line;
  std::getline(told, line);
  std::istringstream fields(line.substr(std::min(line.size(), line.rfind(')') + 2)));
  std::string skipped;
  for (int field = 3; field < 20; ++field) fields >> skipped;
  double started = 0;
  std::uint64_t pages = 0;
  fields >> out.threads >> skipped >> started >> out.virtual_bytes >> pages;
  out.resident_bytes = pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  if (started > 0) out.start_time_s = started_at(started);
  rusage used{};
  if (::getrusage(RUSAGE_SELF, &used) == 0) out.cpu_s = seconds_of(used.ru_utime) + seconds_of(used.ru_stime);
  rlimit files{};
  if (::getrlimit(RLIMIT_NOFILE, &files) == 0) out.open_files_max = files.rlim_cur;
  FolderReader reader("/proc/self/fd");
  while (reader.next()) ++out.open_files;
  if (out.open_files > 0) --out.open_files;  // the descriptor of this reader
  return out;
}

}  // namespace tessera::service::http
