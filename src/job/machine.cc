#include "src/job/machine.h"

#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>
#include <string>

namespace tessera {
namespace {

// Returns the value of a "Name:   123 kB" line, in bytes.
std::optional<std::uint64_t> kilobyte_line(const char* path, const std::string& name) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with(name + ":")) continue;
    std::istringstream words(line.substr(name.size() + 1));
    std::uint64_t kilobytes = 0;
    if (words >> kilobytes) return kilobytes * 1024;
  }
  return std::nullopt;
}

std::optional<std::uint64_t> number_in(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::uint64_t number = 0;
  if (file >> number) return number;
  return std::nullopt;  // missing, or "max"
}

// Visits the folders of this process's control group and of the groups around it, the innermost first.
template <class Visit>
void for_each_group(const std::string& root, const std::string& controller, Visit visit) {
  std::ifstream file("/proc/self/cgroup");
  for (std::string line; std::getline(file, line);) {
    const auto first = line.find(':');
    const auto second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    if (line.substr(first + 1, second - first - 1) != controller) continue;
    const std::filesystem::path base(root);
    auto group = std::filesystem::path(line.substr(second + 1)).relative_path();
    while (true) {
      visit(base / group);
      if (group.empty()) break;
      group = group.parent_path();
    }
  }
}

}  // namespace

std::uint64_t available_memory() {
  std::uint64_t least = kilobyte_line("/proc/meminfo", "MemAvailable").value_or(std::uint64_t{1} << 30);
  const auto limit = [&](std::optional<std::uint64_t> most, std::optional<std::uint64_t> used) {
    if (most) least = std::min(least, *most - std::min(*most, used.value_or(0)));
  };
  for_each_group("/sys/fs/cgroup", "", [&](const std::filesystem::path& group) {
    limit(number_in(group / "memory.max"), number_in(group / "memory.current"));
  });
  for_each_group("/sys/fs/cgroup/memory", "memory", [&](const std::filesystem::path& group) {
    limit(number_in(group / "memory.limit_in_bytes"), number_in(group / "memory.usage_in_bytes"));
  });
  return least;
}

std::uint64_t default_memory() { return available_memory() / 10 * 7; }

std::uint32_t usable_processors() {
  cpu_set_t set;
  CPU_ZERO(&set);
  std::uint32_t processors = 1;
  if (sched_getaffinity(0, sizeof set, &set) == 0)
    processors = static_cast<std::uint32_t>(std::max(1, CPU_COUNT(&set)));
  for_each_group("/sys/fs/cgroup", "", [&](const std::filesystem::path& group) {
    std::ifstream file(group / "cpu.max");
    double quota = 0, period = 0;
    if (file >> quota >> period && quota > 0 && period > 0) {
      processors = std::min(processors, static_cast<std::uint32_t>(std::max(1.0, std::ceil(quota / period))));
    }
  });
  return processors;
}

std::uint64_t peak_memory() { return kilobyte_line("/proc/self/status", "VmHWM").value_or(0); }

std::string host_name() {
  std::array<char, 256> name{};
  if (::gethostname(name.data(), name.size() - 1) != 0 || name[0] == '\0') return "node";
  return name.data();
}

}  // namespace tessera
