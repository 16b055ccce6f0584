// What the log of a live result says (src/base/files/record_log.h): first of which result it has the changes, then each
// batch of changes in turn.
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
  // `first_new`: the source index of the first new point of the change.
  using Replay = std::function<Status(std::uint64_t first_new, const ResultChange& change)>;
  // Opens the log of the changes since this version of the result, and makes it if there is none. Calls `replay` with
  // the changes in order. Errors: usage when another process has the log, or when the log has changes of another
  // result; those of RecordLog::open(); those of `replay`.
  static Result<LiveLog> open(const std::filesystem::path& out, const Manifest& manifest, const Replay& replay);

  // When this returns without an error, the change survives the end of the process and a power cut.
  Status append(std::uint64_t first_new, const ResultChange& change);
  std::uint64_t bytes() const { return log_.bytes(); }
  std::uint64_t changes() const { return log_.records() - 1; }

 private:
  explicit LiveLog(RecordLog log) : log_(std::move(log)) {}
  RecordLog log_;
};

}  // namespace tessera
