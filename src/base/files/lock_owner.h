// The owner of a folder's lock, as the name of a file.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace tessera {

struct LockOwner {
  std::string host;           // for people; two machines may have the same name
  std::string boot;           // the id of the kernel's boot, unlike any other
  std::string pid_namespace;  // the namespace in which `process` is a number
  std::int64_t process = 0;
  std::uint64_t started = 0;  // in clock ticks since the boot; tells apart processes with the same number
  std::string token;          // different for each lock

  static LockOwner this_process();  // makes a new token
  // Returns nothing for a name that name() does not make.
  static std::optional<LockOwner> from_name(const std::string& name);
  std::string name() const;

  // Whether the owner ran since the same boot of the same kernel as this process.
  bool under_this_kernel() const;
  // Whether the owner's process may be alive. True when unsure. REQUIRES: under_this_kernel().
  bool may_be_alive() const;
};

}  // namespace tessera
