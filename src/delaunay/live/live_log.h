// What the log of a live result says (src/base/files/record_log.h): first of which version of the result it has the
// changes, then each batch of changes in turn. Before the changes become a new version of the result, a last record
// says which version that will be. So the log of the version before can be told from one whose changes the result does
// not have: a process may end before it removes the log.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "src/base/files/record_log.h"
#include "src/base/result.h"
#include "src/delaunay/update/update.h"
#include "src/result/store/tile_store.h"

namespace tessera {

// Not thread-safe.
class LiveLog {
 public:
  // `number`: the number of the live version from which the changes lead on. Numbers go on from log to log.
  using Begin = std::function<void(std::uint64_t number)>;
  // `first_new`: the source index of the first new point of the change.
  using Replay = std::function<Status(std::uint64_t first_new, const ResultChange& change)>;
  // Opens the log of the changes since this version of the result, and makes it if there is none. Calls `begin`, then
  // `replay` with the changes in order. Removes logs of older versions whose changes the result has. Errors: usage when
  // another process has the log, or when a log has changes that are not of this result; those of RecordLog::open();
  // those of `replay`.
  static Result<LiveLog> open(const std::filesystem::path& out, const Manifest& manifest, const Begin& begin,
                              const Replay& replay);

  // When this returns without an error, the change survives the end of the process and a power cut. After an error:
  // unless intact(), it is not known whether the log has the change.
  Status append(std::uint64_t first_new, const ResultChange& change);
  // Notes that the changes so far will be this version of the result. The result itself is changed afterwards.
  Status note_version(std::uint32_t version, const Digest& digest);
  bool intact() const { return log_.intact(); }
  std::uint64_t records() const { return log_.records(); }
  std::uint64_t bytes() const { return log_.bytes(); }

 private:
  explicit LiveLog(RecordLog log) : log_(std::move(log)) {}
  RecordLog log_;
};

}  // namespace tessera
