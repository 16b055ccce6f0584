// What one job or question may take of the machine, and whether it should go on. All threads of the job draw from one
// ledger.
//
// A thread that works for a job holds a Ledger::Use. Then src/base/files draws everything that the thread writes,
// except frames (files/frame.h), from the job's ledger first, and refuses to write when the job is to stop. So a new
// kind of job has a bound on disk, and ends when told to, before its author thinks of either. Code that computes for
// long without writing must ask go_on() or look at token().
//
// Frames are the scratch of a run. A stopped ledger refuses every write, but a stopped job still writes the frames with
// which it can continue later. So frames are not drawn when they are written. A triangulation of the daemon measures
// the folder of its run instead, and draws the growth with written_by_others() (src/service/processes/disk_watch.h).
//
// A Ledger may be used by any thread.
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
    std::string name = {};  // the name in sentences: "limits.disk, 30 MiB,"
  };
  struct Bounds {
    Bound disk = {};    // bytes written, including files that were removed again
    Bound memory = {};  // bytes held at once, as far as they are counted
    Bound files = {};   // named input files
    // The bytes of the disk that must stay free, however many jobs write. free_bytes() says how many are free now. With
    // a null function the disk is not checked.
    std::uint64_t reserve_bytes = 0;
    std::function<std::uint64_t()> free_bytes = {};
  };

  Ledger() : Ledger(Bounds{}) {}
  explicit Ledger(Bounds bounds) : bounds_(std::move(bounds)) {}

  // write(), hold() and name_files() are called before the bytes are written or held and the files are named. Errors:
  // interrupted when the work is to stop; memory, naming the bound, when more is taken than the bound allows; io when
  // less than the reserve would be left on the disk. The first error memory or io becomes reason() and stops all work
  // that draws from this ledger.
  Status write(std::uint64_t bytes);
  Status hold(std::uint64_t bytes);
  Status name_files(std::uint64_t files);
  void give_back(std::uint64_t held_bytes) { held_ -= held_bytes; }
  // Like write(), for bytes that other processes write for the job. `bytes` is the total so far, which may include
  // bytes of write().
  Status written_by_others(std::uint64_t bytes);

  // Error interrupted, or reason(), when the work is to stop.
  Status go_on() const;
  std::stop_token token() const { return stop_.get_token(); }
  // Stops the work because its result is no longer wanted. stop(why) stops it because it took too much.
  void stop() { stop_.request_stop(); }
  void stop(Error why);
  // Why the work was stopped. Nothing when its result is only not wanted.
  std::optional<Error> reason() const;

  std::uint64_t written() const { return std::max(written_.load(), others_.load()); }
  std::uint64_t held() const { return held_; }

  // The ledger of this thread. Null when the thread has none, as in the command.
  static Ledger* of_thread();
  // write(), hold() and name_files() of this thread's ledger. They succeed when the thread has none.
  static Status draw_write(std::uint64_t bytes);
  static Status draw_memory(std::uint64_t bytes);
  static Status draw_files(std::uint64_t files);

  // token() and reason() of this thread's ledger. Without a ledger the token is never stopped and there is no reason.
  static std::stop_token token_of_thread();
  static std::optional<Error> reason_of_thread();

  // Makes its thread draw from `ledger`, or from none, until destroyed. Each thread that a job starts needs a Use of
  // its own.
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
  std::atomic<std::uint64_t> looked_at_{0};  // the value of written and others at the last look at the disk
  mutable std::mutex mutex_;
  std::optional<Error> reason_;
};

}  // namespace tessera
