// How a process has ended, for the next one on the same scratch. It keeps a record there, in memory that outlives it:
// what it is doing, that it ends and why, or the signal that ends it. Where a record says nothing, nothing could be
// said: of the ways in which a process ends only SIGKILL leaves it no word, and an overflow of a stack. Whether the
// kernel has killed for want of memory, the control groups tell that were there before and still are. No other process
// is needed, so it is the same under systemd, as PID 1 of a container, and under `tessera cluster up`.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "src/base/result.h"

namespace tessera {

class LastWords {
 public:
  // Reads what the process before has left, and begins a record of its own. From now on signals by which a process ends
  // unless it heeds them leave their number in it, and end it all the same. One at a time. Error io.
  static Result<std::unique_ptr<LastWords>> keep(const std::filesystem::path& scratch);
  ~LastWords();
  LastWords(const LastWords&) = delete;
  LastWords& operator=(const LastWords&) = delete;

  // "was killed (SIGKILL), ..."; empty when the one before ended in order, or there was none.
  const std::string& before() const { return before_; }
  // "splaying tiles of 2 jobs". By one thread.
  void doing(std::string_view what);
  // It ends, and not in order: "ended with status 4: ...".
  void ends(std::string_view how);
  // It ends in order, or with what went wrong. After other words it changes nothing.
  void ends(const Status& served);
  // A signal that was heeded so far ends the process from now on.
  static void end_by(int signal);

 private:
  struct Record;
  explicit LastWords(Record* record) : record_(record) {}

  Record* record_;
  std::string before_;
};

}  // namespace tessera
