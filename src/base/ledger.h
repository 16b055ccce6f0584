// What one job or one question may take of the machine, and whether it goes on. All its threads draw from one ledger.
//
// A thread that works for a job holds a Ledger::Use. All that src/base/files writes on such a thread is drawn from the
// job's ledger first, and refused when the job is to stop. So a new kind of job has a bound of disk, and ends when it
// is told to, before its author thinks of either. Who computes for long without writing asks go_on() or looks at
// token().
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <functional>
#include <limits>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>

#include "src/base/result.h"

namespace tessera {

class Ledger {
 public:
  struct Bound {
    std::uint64_t most = std::numeric_limits<std::uint64_t>::max();
    std::string name = {};  // what sentences call it: "limits.disk, 30 MiB,"
  };
  struct Bounds {
    Bound disk = {};    // bytes written, also those of files that are removed again
    Bound memory = {};  // bytes held at once, of what is counted
    Bound files = {};   // inputs that are named
    // Bytes of the disk that stay free, whoever takes them; `free_bytes` tells how many there are. Null: nobody looks.
    std::uint64_t reserve_bytes = 0;
    std::function<std::uint64_t()> free_bytes = {};
  };

  Ledger() : Ledger(Bounds{}) {}
  explicit Ledger(Bounds bounds) : bounds_(std::move(bounds)) {}

  // The next three come before what they count. Errors: interrupted when the work is to stop; memory, which names the
  // bound, for more than it allows; io for a disk that would have less free than the reserve. The first error that is
  // not a stop is reason() from then on, and stops all that draws from this ledger.
  Status write(std::uint64_t bytes);
  Status hold(std::uint64_t bytes);
  Status name_files(std::uint64_t files);
  void give_back(std::uint64_t held_bytes) { held_ -= held_bytes; }
  // The same of what others have written for the job: so many bytes are there by now, those of write() among them.
  Status written_by_others(std::uint64_t bytes);

  // Error interrupted when the work is to stop.
  Status go_on() const;
  std::stop_token token() const { return stop_.get_token(); }
  // Nobody wants the work any more. The second form says why: it took too much of something.
  void stop() { stop_.request_stop(); }
  void stop(Error why);
  // Why the work was stopped, unless it only is not wanted any more.
  std::optional<Error> reason() const;

  std::uint64_t written() const { return std::max(written_.load(), others_.load()); }
  std::uint64_t held() const { return held_; }

  // The ledger from which this thread draws; null when there is none, as in the command.
  static Ledger* of_thread();
  // write(), hold() and name_files() for the ledger of this thread, if it has one.
  static Status draw_write(std::uint64_t bytes);
  static Status draw_memory(std::uint64_t bytes);
  static Status draw_files(std::uint64_t files);

  // token() and reason() of that ledger; without one a token that nobody stops, and none.
  static std::stop_token token_of_thread();
  static std::optional<Error> reason_of_thread();

  // While it lives, its thread draws from `ledger`, or from none. Threads that a job starts need one of their own.
  class Use {
   public:
    explicit Use(Ledger* ledger);
    ~Use();
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;

   private:
    Ledger* before_;
  };

 private:
  Status refuse(Error why);
  Status take(std::atomic<std::uint64_t>& from, std::uint64_t amount, const Bound& bound, const char* what);
  Status look_at_disk(std::uint64_t bytes);

  const Bounds bounds_;
  std::stop_source stop_;
  std::atomic<std::uint64_t> written_{0}, others_{0}, held_{0}, files_{0};
  std::atomic<std::uint64_t> looked_at_{0};  // written when the free bytes were looked at
  mutable std::mutex mutex_;
  std::optional<Error> reason_;
};

}  // namespace tessera
