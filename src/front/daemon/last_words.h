// Tells a process how the process before it on the same scratch folder has ended. Each process keeps a record in a
// mapped file, which outlives the process: what it is doing, that it ends and why, or the signal that ends it. Only
// SIGKILL and a stack overflow leave no time to write the record, so a record without an end means one of these. The
// control groups of the process tell whether the kernel has killed for want of memory. No other process is needed, so
// this works under systemd, as PID 1 of a container, and under `tessera cluster up` alike.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "src/base/result.h"

namespace tessera::daemon {

class LastWords {
 public:
  // Reads the record of the process before, and begins a new one. From now on each signal that ends a process by
  // default writes its number into the record, and ends the process all the same. SIGTERM and SIGINT are left out; see
  // end_by(). Only one LastWords may exist at a time. Error io.
  static Result<std::unique_ptr<LastWords>> keep(const std::filesystem::path& scratch);
  ~LastWords();
  LastWords(const LastWords&) = delete;
  LastWords& operator=(const LastWords&) = delete;

  // Returns how the process before ended: "was killed (SIGKILL), ..."; "" if it ended in order, or there was none.
  const std::string& before() const { return before_; }
  // Records what the process is doing: "splaying tiles of 2 jobs". REQUIRES: always the same thread.
  void doing(std::string_view what);
  // Records that the process ends, and not in order: "ended with status 4: ...". The first call of either ends()
  // counts.
  void ends(std::string_view how);
  // Records that the process ends in order (success), or with an error.
  void ends(const Status& served);
  // From now on this signal ends the process, and is recorded. For signals that the process has handled so far.
  static void end_by(int signal);

 private:
  struct Record;
  explicit LastWords(Record* record) : record_(record) {}

  Record* record_;
  std::string before_;
};

}  // namespace tessera::daemon
