#include "src/service/results/result_folders.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "src/base/files/checksum.h"
#include "src/base/files/folder.h"
#include "src/base/files/names.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/base/random_token.h"
#include "src/result/held_manifest.h"
#include "src/service/beneath.h"
#include "src/service/naming.h"
#include "src/service/problem.h"
#include "src/service/processes/kinds.h"
#include "src/service/results/owners.h"

namespace tessera::service {
namespace fs = std::filesystem;
namespace {

constexpr const char* program = "tesserad";
constexpr std::size_t manifests_max = 16;

// The identity of a file that is only replaced by renaming: other contents mean another file.
std::string identity(const struct stat& status) {
  const std::uint64_t parts[] = {status.st_dev, status.st_ino, static_cast<std::uint64_t>(status.st_size),
                                 static_cast<std::uint64_t>(status.st_mtim.tv_sec),
                                 static_cast<std::uint64_t>(status.st_mtim.tv_nsec)};
  return checksum_text(checksum(std::as_bytes(std::span(parts))));
}

// The file's checksum in the manifest; empty when the manifest has none.
std::string checksum_in(const Manifest& manifest, const fs::path& path) {
  if (path == master_file("")) return checksum_text(manifest.master_xxh3);
  if (path == duplicates_of("", manifest)) return checksum_text(manifest.duplicates_xxh3);
  if (path == duplicate_rows_of("", manifest)) return checksum_text(manifest.duplicate_rows_xxh3);
  for (const auto& entry : manifest.tiles)
    if (path == tile_file("", entry)) return checksum_text(entry.xxh3);
  return "";
}

// True if clients may read this path in a result.
bool is_served(const fs::path& path) {
  if (path.empty() || path.is_absolute()) return false;
  for (const auto& part : path)
    if (!check_name(part.string()) || is_temporary_name(part)) return false;
  const auto parent = path.parent_path();
  if (parent.empty()) return is_result_name(path);
  if (parent == tiles_folder("")) return is_tile_name(path) && !is_done_name(path);
  return *path.begin() == exports_folder("");
}

}  // namespace

ResultFolders::ResultFolders(const fs::path& data, StagingFolder& desk) : results_(results_folder(data)), desk_(desk) {}

fs::path ResultFolders::folder(std::string_view name) const { return results_ / std::string(name); }
fs::path ResultFolders::folder(std::string_view name, std::uint32_t version) const {
  return version == 0 ? folder(name) : version_file(folder(name), version);
}
fs::path ResultFolders::unfinished(const std::string& job) const { return unfinished_folder(results_, job); }
fs::path ResultFolders::unfinished_export(std::string_view name, const std::string& job) const {
  return unfinished_folder(exports_folder(folder(name)), job);
}

Result<std::vector<std::string>> ResultFolders::names() const {
  BOOST_OUTCOME_TRY(names, sorted_names(results_));
  std::vector<std::string> results;
  for (const auto& name : names) {
    // A result that cannot be read is listed: requests for it report why.
    const auto there = exists(name);
    if (!there || there.value()) results.push_back(name);
  }
  return results;
}

Result<bool> ResultFolders::exists(std::string_view name) const {
  if (!check_name(name)) return false;
  BOOST_OUTCOME_TRY(there, is_folder(folder(name), FollowLinks::no));
  if (!there) return false;
  return is_there(manifest_file(folder(name)));
}

Result<bool> ResultFolders::export_exists(std::string_view name, const std::string& file) const {
  return is_there(exports_folder(folder(name)) / file, FollowLinks::no);
}

std::vector<std::string> ResultFolders::command_of(const proto::JobRecord& job) {
  return {program, process_of(job.inputs()), job.id(), job.caller()};
}

bool ResultFolders::is_of(const std::vector<std::string>& command, const proto::JobRecord& job) {
  const auto whole = command_of(job);
  constexpr std::size_t first_words = 3;  // up to the id of the job
  return command.size() >= first_words && std::equal(whole.begin(), whole.begin() + first_words, command.begin());
}

Result<ResultFolders::Maker> ResultFolders::maker(std::string_view name) {
  BOOST_OUTCOME_TRY(there, exists(name));
  if (!there) return Maker{};
  const auto found = manifest(name);
  if (!found && found.error().code == Errc::io) return found.error();
  if (!found) return Maker{};
  const auto& command = found.value()->command;
  // Older commands end with the job.
  if ((command.size() != 3 && command.size() != 4) || command.front() != program) return Maker{};
  return Maker{command[2], command.size() == 4 ? command[3] : ""};
}

Result<bool> ResultFolders::made_by(std::string_view name, const std::string& job) {
  BOOST_OUTCOME_TRY(known, maker(name));
  return known.job == job;
}

Result<ResultFolders::Held> ResultFolders::hold(std::string_view name, std::uint32_t version) {
  if (const auto fits = check_name(name); !fits)
    return error(Errc::usage, "the name of the triangulation " + fits.error().where);
  Held held;
  BOOST_OUTCOME_TRY(folder, open_handle(this->folder(name), O_PATH | O_DIRECTORY | O_NOFOLLOW));
  held.folder = std::move(folder);
  const fs::path out = path_of(held.folder);
  struct stat status {};
  const auto describe = [&] {
    held.identity = identity(status);
    held.created = time_of_file(status.st_mtim.tv_sec, status.st_mtim.tv_nsec);
    held.manifest = known_manifest(held.identity);
  };
  const auto file = version == 0 ? manifest_file(out) : version_file(out, version);
  BOOST_OUTCOME_TRY(found, look_at(file));
  if (!found && version == 0) return io_error(manifest_file(this->folder(name)), "cannot be read", ENOENT);
  if (found) {
    status = *found;
    describe();
  }
  if (held.manifest) return held;
  // A writer may replace the file at any time. The identity must be that of the manifest that is read.
  BOOST_OUTCOME_TRY(read, version == 0 ? result::hold_manifest(out) : result::hold_version(out, version));
  if (::fstat(read.file.get(), &status) != 0)
    return io_error(manifest_file(this->folder(name)), "cannot be read", errno);
  describe();
  if (held.manifest) return held;
  held.manifest = std::make_shared<const Manifest>(std::move(read.manifest));
  keep_manifest(held.identity, held.manifest);
  return held;
}

std::shared_ptr<const Manifest> ResultFolders::known_manifest(const std::string& identity) {
  const std::lock_guard lock(mutex_);
  const auto found = manifests_.find(identity);
  return found == manifests_.end() ? nullptr : found->second;
}

void ResultFolders::keep_manifest(const std::string& identity, const std::shared_ptr<const Manifest>& manifest) {
  const std::lock_guard lock(mutex_);
  if (manifests_.size() >= manifests_max) manifests_.clear();
  manifests_[identity] = manifest;
}

Result<std::optional<ResultFolders::Held>> ResultFolders::find(std::string_view name) {
  BOOST_OUTCOME_TRY(there, exists(name));
  if (!there) return std::optional<Held>();
  auto held = hold(name);
  if (held) return std::optional(std::move(held).value());
  // It may have been removed just now.
  BOOST_OUTCOME_TRY(still_there, exists(name));
  if (still_there) return held.error();
  return std::optional<Held>();
}

Result<std::shared_ptr<const Manifest>> ResultFolders::manifest(std::string_view name, std::uint32_t version) {
  BOOST_OUTCOME_TRY(held, hold(name, version));
  return held.manifest;
}

Reply<proto::TriangulationInfo> ResultFolders::info(std::string_view name) {
  const auto nothing = [&] { return problem(404, "there is no triangulation '" + std::string(name) + "'"); };
  const auto found = find(name);
  if (!found) return problem_of(found.error());
  if (!found.value()) return nothing();
  const Held& held = *found.value();
  const Manifest& manifest = *held.manifest;
  proto::TriangulationInfo info;
  info.set_name(std::string(name));
  info.set_dimension(manifest.dimension);
  info.set_vertices(manifest.vertices);
  info.set_cells(manifest.cells);
  info.set_tiles(manifest.tiles.size());
  std::uint64_t bytes = 0;
  for (const auto& tile : manifest.tiles) bytes += tile.bytes;
  info.set_bytes(bytes);
  if (manifest.digest) info.set_digest(digest_text(*manifest.digest));
  info.set_created(held.created);
  info.set_version(manifest.version);
  info.set_crs(manifest.crs);
  const auto tileset = export_exists(name, tileset_of_result("").filename().string());
  if (!tileset) return problem_of(tileset.error());
  info.set_tileset(tileset.value());
  const auto& box = manifest.bounds;
  if (!box.empty()) {
    for (const Point& corner : {box.lo, box.hi})
      for (int axis = 0; axis < manifest.dimension; ++axis) info.add_bounds(corner[axis]);
  }
  if (const auto heights = heights_of(manifest)) {
    info.add_heights(heights->lo);
    info.add_heights(heights->hi);
  }
  return info;
}

Reply<ServedFile> ResultFolders::file(std::string_view name, std::string_view path) {
  const auto nothing = [&] {
    return problem(404, "there is no file '" + std::string(path) + "' in a triangulation '" + std::string(name) + "'");
  };
  const fs::path inside{std::string(path)};
  if (!is_served(inside)) return nothing();
  const auto found = find(name);
  if (!found) return problem_of(found.error());
  if (!found.value()) return nothing();
  const Held& held = *found.value();
  auto opened = open_if_there(held.folder, inside.string(), O_RDONLY, Links::refused);
  if (!opened && opened.error().code == Errc::io) return problem_of(opened.error());
  if (!opened || !opened.value()) return nothing();
  struct stat status {};
  if (::fstat(opened.value()->get(), &status) != 0) return problem_of(io_error(inside, "cannot be looked at", errno));
  if (!S_ISREG(status.st_mode)) return nothing();
  auto sum = checksum_in(*held.manifest, inside);
  const bool page = inside == report_file("");
  auto sent = served(*std::move(opened).value(), inside, page ? "text/html; charset=utf-8" : media_type_of(inside),
                     sum.empty() ? "file-" + identity(status) : "xxh3-" + sum);
  if (!sent) return problem_of(sent.error());
  return sent.value();
}

}  // namespace tessera::service
