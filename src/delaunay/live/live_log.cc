#include "src/delaunay/live/live_log.h"

#include <string>
#include <utility>

#include "src/base/files/live_names.h"
#include "src/base/files/whole_file.h"
#include "src/base/flat_codec.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

enum Kind : std::uint32_t { identity = 0, batch = 1 };

// The result whose changes the log has. The digest tells it from any other.
struct Identity {
  std::uint32_t format = 1;
  std::uint32_t version = 0;
  std::uint64_t points_read = 0, row_bytes = 0;
  Digest digest = {};
  std::uint64_t has_digest = 0;
  friend bool operator==(const Identity&, const Identity&) = default;
};

Identity identity_of(const Manifest& manifest) {
  return {.version = manifest.version,
          .points_read = manifest.points_read,
          .row_bytes = row_bytes(manifest.schema),
          .digest = manifest.digest.value_or(Digest{}),
          .has_digest = manifest.digest ? 1u : 0u};
}

}  // namespace

Result<LiveLog> LiveLog::open(const fs::path& out, const Manifest& manifest, const Replay& replay) {
  BOOST_OUTCOME_TRYV(make_directories(live_folder(out)));
  BOOST_OUTCOME_TRYV(sync_folder(out));
  const fs::path path = live_log_file(out, manifest.version);
  const Identity wanted = identity_of(manifest);
  bool first = true;
  const auto visit = [&](std::uint32_t kind, std::span<const std::byte> payload) -> Status {
    FlatReader in(payload);
    const auto damaged = [&] { return error(Errc::corrupt, path.string() + ": a record has a content of no change"); };
    if (std::exchange(first, false)) {
      Identity found;
      if (kind != identity || !in.value(found) || !in.at_end()) return damaged();
      if (found == wanted) return success();
      return error(Errc::usage, path.string() + ": this log has changes of another result than " + out.string() +
                                    "; move the log away if the changes are not wanted");
    }
    std::uint64_t first_new = 0;
    ResultChange change;
    if (kind != batch || !in.value(first_new) || !in.list(change.add) || !in.list(change.rows) ||
        !in.list(change.remove) || !in.at_end() || change.rows.size() != change.add.size() * wanted.row_bytes)
      return damaged();
    return replay(first_new, change);
  };
  BOOST_OUTCOME_TRY(records, RecordLog::open(path, visit));
  LiveLog log(std::move(records));
  if (first) {
    FlatWriter bytes;
    bytes.value(wanted);
    BOOST_OUTCOME_TRYV(log.log_.append(identity, bytes.take()));
  }
  return log;
}

Status LiveLog::append(std::uint64_t first_new, const ResultChange& change) {
  FlatWriter bytes;
  bytes.reserve(32 + change.add.size() * sizeof(Point) + change.rows.size() + change.remove.size() * sizeof(PointId));
  bytes.value(first_new);
  bytes.list(change.add);
  bytes.list(change.rows);
  bytes.list(change.remove);
  return log_.append(batch, bytes.take());
}

}  // namespace tessera
