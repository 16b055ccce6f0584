// Processes of this machine that outlive the one that started them.
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

namespace tessera {

// What is remembered of one: its number, and when it began, for the number may be another's later.
struct ProcessId {
  pid_t number = 0;  // 0: none
  std::uint64_t started = 0;
};

struct StartedProcess {
  ProcessId id;
  FileHandle output;  // reads its stdout
};

// In a session of its own, which no Ctrl-C of this one reaches; without input, and without variables whose names begin
// with `hidden`. stderr is appended to `log`. Error io.
Result<StartedProcess> start_process(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                                     const std::filesystem::path& log, const std::string& hidden);

// A process that runs, and no other one.
class RunningProcess {
 public:
  // Nothing when it has ended. Error io when the system cannot tell.
  static Result<std::optional<RunningProcess>> find(const ProcessId& id);
  // One that has ended meanwhile gets none. Error io.
  Status signal(int number) const;
  // Waits so long. Whether it has ended.
  bool ends_within(std::chrono::milliseconds time) const;

 private:
  explicit RunningProcess(FileHandle handle) : handle_(std::move(handle)) {}
  FileHandle handle_;
};

}  // namespace tessera
