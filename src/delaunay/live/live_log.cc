#include "src/delaunay/live/live_log.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <string>
#include <utility>

#include "src/base/files/folder.h"
#include "src/base/files/live_names.h"
#include "src/base/files/whole_file.h"
#include "src/base/flat_codec.h"
#include "src/result/version_log.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

enum Kind : std::uint32_t { identity = 0, batch = 1, version_made = 2 };

struct MadeVersion {
  std::uint64_t version = 0;
  Digest digest = {};
};

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

// The number in a log's name; nothing for other names.
std::optional<std::uint32_t> version_of_log(const fs::path& out, const std::string& name) {
  std::uint32_t version = 0;
  const auto [end, code] = std::from_chars(name.data(), name.data() + name.size(), version);
  if (code != std::errc() || live_log_file(out, version).filename() != name) return std::nullopt;
  return version;
}

// Whether the result has, or has had, this version.
Result<bool> is_in(const fs::path& out, const Manifest& manifest, const MadeVersion& made) {
  if (made.version == manifest.version) return manifest.digest && made.digest == *manifest.digest;
  BOOST_OUTCOME_TRY(log, read_version_log(out, manifest.version));
  return std::any_of(log.versions.begin(), log.versions.end(), [&](const VersionEntry& entry) {
    return entry.version == made.version && entry.digest && made.digest == *entry.digest;
  });
}

// Removes the log of an older version, unless it has changes that are not in the result. Returns the number of the live
// version that the result is now.
Result<std::uint64_t> remove_older(const fs::path& out, const fs::path& path, const Manifest& manifest) {
  std::optional<MadeVersion> last;
  std::uint64_t first = 0, changes = 0;
  const auto visit = [&](std::uint32_t kind, std::span<const std::byte> payload) -> Status {
    changes += kind == batch ? 1 : 0;
    FlatReader in(payload);
    Identity older;
    if (kind == identity && (!in.value(older) || !in.value(first)))
      return error(Errc::corrupt, path.string() + ": a record has a content of no change");
    MadeVersion version;
    last = kind == version_made && in.value(version) ? std::optional(version) : std::nullopt;
    return success();
  };
  { BOOST_OUTCOME_TRYV(RecordLog::open(path, visit)); }
  bool made = false;
  if (last) {
    BOOST_OUTCOME_TRY(in, is_in(out, manifest, *last));
    made = in;
  }
  if (changes == 0 || made) {
    BOOST_OUTCOME_TRYV(remove_file(path));
    // Without changes of the log, and after the version of the log, another program has made the version.
    return first + std::max(changes, std::uint64_t{1}) + (made ? manifest.version - last->version : 0);
  }
  return error(Errc::usage, path.string() +
                                ": this log has changes of an older version of the result, which another program has "
                                "changed since; move the log away if the changes are not wanted");
}

Result<std::uint64_t> remove_older_logs(const fs::path& out, const Manifest& manifest) {
  std::uint64_t number = 0;
  BOOST_OUTCOME_TRY(names, sorted_names(live_folder(out)));
  for (const std::string& name : names) {
    const auto version = version_of_log(out, name);
    if (!version || *version == manifest.version) continue;
    const fs::path path = live_folder(out) / name;
    if (*version > manifest.version)
      return error(Errc::usage, path.string() +
                                    ": this log has changes of a newer version of the result; move the log "
                                    "away if the changes are not wanted");
    BOOST_OUTCOME_TRY(reached, remove_older(out, path, manifest));
    number = std::max(number, reached);
  }
  return number;
}

}  // namespace

Result<LiveLog> LiveLog::open(const fs::path& out, const Manifest& manifest, const Begin& begin, const Replay& replay) {
  BOOST_OUTCOME_TRYV(make_directories(live_folder(out)));
  BOOST_OUTCOME_TRYV(sync_folder(out));
  BOOST_OUTCOME_TRY(number, remove_older_logs(out, manifest));
  const fs::path path = live_log_file(out, manifest.version);
  const Identity wanted = identity_of(manifest);
  bool first = true;
  const auto visit = [&](std::uint32_t kind, std::span<const std::byte> payload) -> Status {
    FlatReader in(payload);
    const auto damaged = [&] { return error(Errc::corrupt, path.string() + ": a record has a content of no change"); };
    if (std::exchange(first, false)) {
      Identity found;
      if (kind != identity || !in.value(found) || !in.value(number) || !in.at_end()) return damaged();
      if (found == wanted) {
        begin(number);
        return success();
      }
      return error(Errc::usage, path.string() + ": this log has changes of another result than " + out.string() +
                                    "; move the log away if the changes are not wanted");
    }
    if (kind == version_made) return success();  // the process ended before the result was changed
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
    bytes.value(number);
    BOOST_OUTCOME_TRYV(log.log_.append(identity, bytes.take()));
    begin(number);
  }
  return log;
}

Status LiveLog::note_version(std::uint32_t version, const Digest& digest) {
  FlatWriter bytes;
  bytes.value(MadeVersion{version, digest});
  return log_.append(version_made, bytes.take());
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
