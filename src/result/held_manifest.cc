#include "src/result/held_manifest.h"

#include <fcntl.h>
#include <sys/file.h>

#include <cerrno>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "src/base/files/names.h"
#include "src/base/files/there.h"

namespace tessera::result {

namespace fs = std::filesystem;

namespace {

// Returns false when a writer has locked the file because it is about to remove this version, which it has replaced.
// File systems without such locks hold nothing. Nothing is lost there, because no writer finds a version unread there.
bool lock_shared(const FileHandle& file) { return ::flock(file.get(), LOCK_SH | LOCK_NB) == 0 || errno != EWOULDBLOCK; }

Result<bool> is_current(const fs::path& path, const FileHandle& file) {
  BOOST_OUTCOME_TRY(now, look_at(path));
  struct stat opened {};
  if (::fstat(file.get(), &opened) != 0) return io_error(path, "cannot be read", errno);
  return now && now->st_ino == opened.st_ino && now->st_dev == opened.st_dev;
}

// Returns nothing when a writer replaced the manifest before it was locked.
Result<std::optional<HeldManifest>> try_hold(const fs::path& path) {
  BOOST_OUTCOME_TRY(file, open_handle(path, O_RDONLY));
  if (!lock_shared(file)) return std::optional<HeldManifest>{};
  BOOST_OUTCOME_TRY(current, is_current(path, file));
  if (!current) return std::optional<HeldManifest>{};
  BOOST_OUTCOME_TRY(size, size_of(file, path));
  std::vector<std::byte> bytes(size);
  BOOST_OUTCOME_TRY(read, read_up_to(file.get(), bytes, 0, path));
  bytes.resize(read);
  BOOST_OUTCOME_TRY(manifest, parse_manifest(path, bytes));
  return std::optional(HeldManifest{std::move(manifest), std::move(file)});
}

}  // namespace

Result<HeldManifest> hold_manifest(const fs::path& out) {
  const auto path = manifest_file(out);
  BOOST_OUTCOME_TRY(there, is_there(path));
  if (!there) return no_manifest(out);
  constexpr int tries_max = 1000;
  for (int i = 0; i < tries_max; ++i) {
    BOOST_OUTCOME_TRY(held, try_hold(path));
    if (held) return std::move(*held);
  }
  return error(Errc::io,
               path.string() + ": other programs replace this file again and again, so that it cannot be read");
}

}  // namespace tessera::result
