#include "src/result/held_manifest.h"

#include <fcntl.h>
#include <sys/file.h>

#include <cerrno>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "src/base/files/names.h"
#include "src/base/files/there.h"
#include "src/result/old_versions.h"

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

// Returns nothing when a writer replaced or removed the manifest before it was locked.
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

// An old version, by one of its files.
Result<std::optional<HeldManifest>> hold_old(const fs::path& out, std::uint32_t version) {
  for (const auto& path : {version_file(out, version), version_copy(out, version)}) {
    BOOST_OUTCOME_TRY(there, is_there(path));
    if (!there) continue;
    BOOST_OUTCOME_TRY(held, try_hold(path));
    if (held) return std::move(held);
  }
  return std::optional<HeldManifest>{};
}

Error no_such_version(const fs::path& out, std::uint32_t version, std::uint32_t newest) {
  const auto readable = readable_versions(out, newest);
  if (!readable) return readable.error();
  const auto& numbers = readable.value();
  std::string list;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    list += (i == 0 ? "" : i + 1 < numbers.size() ? ", " : " and ") + std::to_string(numbers[i]);
  const std::string why = version >= 1 && version < newest ? " is not kept any more" : " does not exist";
  return error(Errc::usage, out.string() + ": version " + std::to_string(version) + why +
                                (numbers.size() == 1 ? "; only version " : "; the versions ") + list + " can be read");
}

}  // namespace

Result<std::vector<std::uint32_t>> readable_versions(const fs::path& out, std::uint32_t newest) {
  std::vector<std::uint32_t> numbers;
  BOOST_OUTCOME_TRY(olds, old_versions(out));
  for (const auto& old : olds) {
    if (old.version < newest && (numbers.empty() || numbers.back() != old.version)) numbers.push_back(old.version);
  }
  numbers.push_back(newest);
  return numbers;
}

Result<HeldManifest> hold_version(const fs::path& out, std::uint32_t version) {
  BOOST_OUTCOME_TRY(newest, hold_manifest(out));
  if (newest.manifest.version == version) return std::move(newest);
  if (version < newest.manifest.version) {
    BOOST_OUTCOME_TRY(held, hold_old(out, version));
    if (held) return std::move(*held);
  }
  return no_such_version(out, version, newest.manifest.version);
}

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
