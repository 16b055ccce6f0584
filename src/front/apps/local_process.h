// Processes on this machine that outlive the process that started them.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "src/base/files/descriptor.h"
#include "src/base/result.h"

namespace tessera::apps {

// Identifies a process by its number and its start time, because the number may belong to another process later.
struct ProcessId {
  pid_t number = 0;  // 0: none
  std::uint64_t started = 0;
};

struct StartedProcess {
  ProcessId id;
  FileHandle output;  // reads the process's stdout
};

// Starts a process in a session of its own, which Ctrl-C in this terminal does not reach. The process has no input, and
// no variables whose names begin with `hidden`. Its stderr is appended to `log`. Error io.
Result<StartedProcess> start_process(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                                     const std::filesystem::path& log, const std::string& hidden);

// A handle of one process, which never means another process with the same number.
class RunningProcess {
 public:
  // Returns the process; no value if it has ended. Error io if the system cannot tell.
  static Result<std::optional<RunningProcess>> find(const ProcessId& id);
  // Sends a signal. Does nothing if the process has ended meanwhile. Error io.
  Status signal(int number) const;
  // Waits for the end of the process, at most so long. Returns whether the process has ended.
  bool ends_within(std::chrono::milliseconds time) const;

 private:
  explicit RunningProcess(FileHandle handle) : handle_(std::move(handle)) {}
  FileHandle handle_;
};

}  // namespace tessera::apps
