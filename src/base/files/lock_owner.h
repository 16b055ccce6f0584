// Who holds a folder's lock, as the name of a file.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace tessera {

struct LockOwner {
  std::string host;           // for people: two machines may have one name
  std::string boot;           // of the kernel: unlike any other's
  std::string pid_namespace;  // in which `process` is a number
  std::int64_t process = 0;
  std::uint64_t started = 0;  // in clock ticks since the boot: tells processes with one number apart
  std::string token;          // of one lock

  static LockOwner this_process();  // with a new token
  // Nothing when the name is not one that name() makes.
  static std::optional<LockOwner> from_name(const std::string& name);
  std::string name() const;

  bool under_this_kernel() const;
  // Known only where processes are seen: REQUIRES under_this_kernel(). True when unsure.
  bool may_be_alive() const;
};

}  // namespace tessera
