#include "src/service/results.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <system_error>
#include <utility>

#include "src/base/random_token.h"
#include "src/files/checksum.h"
#include "src/files/folder.h"
#include "src/files/names.h"
#include "src/files/there.h"
#include "src/files/whole_file.h"
#include "src/service/beneath.h"
#include "src/service/kinds.h"
#include "src/service/naming.h"
#include "src/service/owners.h"
#include "src/service/problem.h"

namespace tessera {
namespace fs = std::filesystem;
namespace {

constexpr const char* program = "tesserad";
constexpr std::size_t manifests_max = 16;

Result<std::vector<std::string>> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  FolderReader reader(folder);
  while (const char* name = reader.next()) names.emplace_back(name);
  if (reader.error()) return error(Errc::io, folder.string() + ": cannot be read: " + reader.error().message());
  std::sort(names.begin(), names.end());
  return names;
}

Status remove_whole(const fs::path& path) {
  if (const auto failed = remove_tree(path)) return io_error(path, "cannot be removed", failed.value());
  return success();
}

// What is ours in a result folder that nobody finds any more; the folder, too, when nothing else is in it.
Status remove_result(const fs::path& folder) {
  BOOST_OUTCOME_TRYV(remove_file(manifest_file(folder)));
  BOOST_OUTCOME_TRYV(remove_whole(exports_folder(folder)));
  BOOST_OUTCOME_TRYV(remove_whole(run_folder(folder)));
  BOOST_OUTCOME_TRY(with_tiles, is_folder(tiles_folder(folder), FollowLinks::no));
  if (with_tiles) {
    BOOST_OUTCOME_TRY(tiles, names_in(tiles_folder(folder)));
    for (const auto& name : tiles) {
      if (!is_tile_name(name)) continue;
      BOOST_OUTCOME_TRYV(remove_file(tiles_folder(folder) / name));
    }
  }
  BOOST_OUTCOME_TRY(names, names_in(folder));
  for (const auto& name : names) {
    if (is_result_name(name)) {
      BOOST_OUTCOME_TRYV(remove_file(folder / name));
    } else if (is_lock_name(name) || is_new_run_name(name)) {
      BOOST_OUTCOME_TRYV(remove_whole(folder / name));
    }
  }
  std::error_code foreign;  // files keep their folders
  fs::remove(tiles_folder(folder), foreign);
  fs::remove(folder, foreign);
  return success();
}

// Of a file that is replaced by renaming alone: another content is another file.
std::string identity(const struct stat& status) {
  const std::uint64_t parts[] = {status.st_dev, status.st_ino, static_cast<std::uint64_t>(status.st_size),
                                 static_cast<std::uint64_t>(status.st_mtim.tv_sec),
                                 static_cast<std::uint64_t>(status.st_mtim.tv_nsec)};
  return checksum_text(checksum(std::as_bytes(std::span(parts))));
}

// The checksum in the manifest; empty when it has none of this file.
std::string checksum_in(const Manifest& manifest, const fs::path& path) {
  if (path == master_file("", manifest.format_version)) return checksum_text(manifest.master_xxh3);
  if (path == duplicates_file("")) return checksum_text(manifest.duplicates_xxh3);
  for (const auto& entry : manifest.tiles)
    if (path == tile_file("", entry.tile, manifest.format_version)) return checksum_text(entry.xxh3);
  return "";
}

// Whether a path in a result is for others to read.
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

Results::Results(const fs::path& data, Desk& desk) : results_(results_folder(data)), desk_(desk) {}

fs::path Results::folder(std::string_view name) const { return results_ / std::string(name); }
fs::path Results::unfinished(const std::string& job) const { return unfinished_folder(results_, job); }
fs::path Results::unfinished_export(std::string_view name, const std::string& job) const {
  return unfinished_folder(exports_folder(folder(name)), job);
}

Status Results::open(const std::set<std::string>& jobs) {
  BOOST_OUTCOME_TRYV(make_directories(results_));
  // `remove`: of what has the name of something that is being removed.
  const auto clear = [&](const fs::path& folder, Status (*remove)(const fs::path&)) -> Status {
    BOOST_OUTCOME_TRY(names, names_in(folder));
    for (const auto& name : names) {
      const auto job = job_of_unfinished(name);
      if (token_of_removed(name)) {
        BOOST_OUTCOME_TRYV(remove(folder / name));
      } else if (JobIds::is_id(job) && !jobs.contains(job)) {
        BOOST_OUTCOME_TRYV(drop(folder / name));
      }
    }
    return success();
  };
  BOOST_OUTCOME_TRYV(clear(results_, remove_result));
  BOOST_OUTCOME_TRY(results, names());
  for (const auto& name : results) {
    BOOST_OUTCOME_TRY(with_exports, is_folder(exports_folder(folder(name)), FollowLinks::no));
    if (!with_exports) continue;
    BOOST_OUTCOME_TRYV(clear(exports_folder(folder(name)), remove_whole));
  }
  return success();
}

Result<std::vector<std::string>> Results::names() const {
  BOOST_OUTCOME_TRY(names, names_in(results_));
  std::vector<std::string> results;
  for (const auto& name : names) {
    // One that cannot be looked at is listed: whoever asks for it hears why.
    const auto there = exists(name);
    if (!there || there.value()) results.push_back(name);
  }
  return results;
}

Result<bool> Results::exists(std::string_view name) const {
  if (!check_name(name)) return false;
  BOOST_OUTCOME_TRY(there, is_folder(folder(name), FollowLinks::no));
  if (!there) return false;
  return is_there(manifest_file(folder(name)));
}

Result<bool> Results::export_exists(std::string_view name, const std::string& file) const {
  return is_there(exports_folder(folder(name)) / file, FollowLinks::no);
}

std::vector<std::string> Results::command_of(const proto::JobRecord& job) {
  return {program, process_of(job.inputs()), job.id(), job.caller()};
}

Result<Results::Maker> Results::maker(std::string_view name) {
  BOOST_OUTCOME_TRY(there, exists(name));
  if (!there) return Maker{};
  const auto found = manifest(name);
  if (!found && found.error().code == Errc::io) return found.error();
  if (!found) return Maker{};
  const auto& command = found.value()->command;
  // Older ones end with the job.
  if ((command.size() != 3 && command.size() != 4) || command.front() != program) return Maker{};
  return Maker{command[2], command.size() == 4 ? command[3] : ""};
}

Result<bool> Results::made_by(std::string_view name, const std::string& job) {
  BOOST_OUTCOME_TRY(known, maker(name));
  return known.job == job;
}

Result<bool> Results::is_published(const std::string& job, std::string_view name) {
  BOOST_OUTCOME_TRY(unpublished, is_there(unfinished(job), FollowLinks::no));
  if (unpublished) return false;
  return made_by(name, job);
}

Result<fs::path> Results::publish(const std::string& job, const std::string& name, bool overwrite) {
  const auto made = unfinished(job);
  BOOST_OUTCOME_TRY(published, is_published(job, name));
  if (published) return fs::path();  // before a crash
  fs::path replaced;
  BOOST_OUTCOME_TRY(anything, is_there(folder(name), FollowLinks::no));
  if (anything) {
    BOOST_OUTCOME_TRY(result, exists(name));
    if (!overwrite || !result)
      return error(Errc::usage, "output: there is something called '" + name + "' already, which is not replaced");
    // Until the new one stands there, the old one is what a successor puts back.
    BOOST_OUTCOME_TRY(picked_up, desk_.pick_up(folder(name)));
    replaced = std::move(picked_up);
  }
  if (const Status moved = desk_.move(made, folder(name)); !moved) {
    if (!replaced.empty()) static_cast<void>(desk_.put_down(replaced, folder(name)));  // else a successor does
    return moved.error();
  }
  BOOST_OUTCOME_TRYV(sync_folder(results_));
  if (replaced.empty()) return replaced;
  const fs::path gone = removed_folder(results_, random_token());
  BOOST_OUTCOME_TRYV(desk_.put_down(replaced, gone));
  return gone;
}

// A new name first, over the desk: a job of that id may be another daemon's by now.
Status Results::drop(const fs::path& folder) {
  BOOST_OUTCOME_TRY(any, is_there(folder, FollowLinks::no));
  if (!any) return success();
  const fs::path gone = removed_folder(folder.parent_path(), random_token());
  BOOST_OUTCOME_TRYV(desk_.move(folder, gone));
  return remove_whole(gone);
}

Status Results::drop_unfinished(const std::string& job) { return drop(unfinished(job)); }
Status Results::drop_unfinished_export(std::string_view exported_from, const std::string& job) {
  return drop(unfinished_export(exported_from, job));
}

Status Results::discard(const fs::path& folder) {
  if (folder.empty()) return success();
  return remove_result(folder);
}

Result<std::string> Results::export_owner(std::string_view name, const std::string& file) const {
  return owner_of(exports_folder(folder(name)) / file);
}

Status Results::publish_export(const proto::JobRecord& job) {
  const auto& name = job.triangulation();
  const auto output = export_output(job.inputs()).value_or("");
  const auto made = unfinished_export(name, job.id());
  const auto to = exports_folder(folder(name));
  std::set<std::string> replaceable{job.caller()};  // whose
  BOOST_OUTCOME_TRY(replaced, export_exists(name, output));
  if (replaced) {
    BOOST_OUTCOME_TRY(owner, export_owner(name, output));
    replaceable.insert(owner);
  }
  BOOST_OUTCOME_TRY(files, names_in(made));
  for (const auto& file : files) {
    BOOST_OUTCOME_TRY(stands, export_exists(name, file));
    if (file == output || !stands) continue;
    BOOST_OUTCOME_TRY(owner, export_owner(name, file));
    if (!replaceable.contains(owner))
      return error(Errc::usage, "output: it would replace the export '" + file + "', which somebody else has made");
  }
  BOOST_OUTCOME_TRY(ours, desk_.pick_up(made));
  const auto published = [&]() -> Status {
    for (const auto& file : files) {
      BOOST_OUTCOME_TRY(in_the_way, is_folder(to / file, FollowLinks::no));
      if (in_the_way) {  // cannot be renamed over
        BOOST_OUTCOME_TRYV(remove_export(name, file));
      }
      BOOST_OUTCOME_TRYV(set_owner(desk_, to / file, job.caller()));
      BOOST_OUTCOME_TRYV(desk_.put_down(ours / file, to / file));
    }
    return sync_folder(to);
  }();
  if (!published) {
    static_cast<void>(desk_.put_down(ours, made));  // else a successor does
    return published;
  }
  return remove_whole(ours);
}

Status Results::remove_export(std::string_view name, const std::string& file) {
  const auto exports = exports_folder(folder(name));
  const auto gone = removed_folder(exports, random_token());
  BOOST_OUTCOME_TRYV(desk_.move(exports / file, gone));
  BOOST_OUTCOME_TRYV(remove_whole(gone));
  return forget_owner(exports / file);
}

Result<fs::path> Results::take_away(std::string_view name) {
  auto gone = removed_folder(results_, random_token());
  BOOST_OUTCOME_TRYV(desk_.move(folder(name), gone));
  BOOST_OUTCOME_TRYV(sync_folder(results_));
  return gone;
}

Result<Results::Held> Results::hold(std::string_view name) {
  if (const auto fits = check_name(name); !fits) return error(Errc::usage, "the name " + fits.error().where);
  Held held;
  BOOST_OUTCOME_TRY(folder, open_handle(this->folder(name), O_PATH | O_DIRECTORY | O_NOFOLLOW));
  held.folder = std::move(folder);
  const auto file = manifest_file(path_of(held.folder));
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return io_error(manifest_file(this->folder(name)), "cannot be read", errno);
  const auto key = identity(status);
  held.identity = key;
  held.created = time_text(std::chrono::system_clock::from_time_t(status.st_mtim.tv_sec) +
                           std::chrono::milliseconds(status.st_mtim.tv_nsec / 1'000'000));
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = manifests_.find(key); found != manifests_.end()) held.manifest = found->second;
  }
  if (held.manifest) return held;
  BOOST_OUTCOME_TRY(manifest, read_manifest(path_of(held.folder)));
  held.manifest = std::make_shared<const Manifest>(std::move(manifest));
  const std::lock_guard lock(mutex_);
  if (manifests_.size() >= manifests_max) manifests_.clear();
  manifests_[key] = held.manifest;
  return held;
}

Result<std::optional<Results::Held>> Results::find(std::string_view name) {
  BOOST_OUTCOME_TRY(there, exists(name));
  if (!there) return std::optional<Held>();
  auto held = hold(name);
  if (held) return std::optional(std::move(held).value());
  // It may have been removed just now.
  BOOST_OUTCOME_TRY(still_there, exists(name));
  if (still_there) return held.error();
  return std::optional<Held>();
}

Result<std::shared_ptr<const Manifest>> Results::manifest(std::string_view name) {
  BOOST_OUTCOME_TRY(held, hold(name));
  return held.manifest;
}

Reply<proto::TriangulationInfo> Results::info(std::string_view name) {
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
  info.set_crs(manifest.crs);
  const auto tileset = export_exists(name, tileset_of_result("").filename().string());
  if (!tileset) return problem_of(tileset.error());
  info.set_tileset(tileset.value());
  const auto& box = manifest.bounds;
  if (!box.empty()) {
    for (const Point& corner : {box.lo, box.hi})
      for (int axis = 0; axis < manifest.dimension; ++axis) info.add_bounds(corner[axis]);
  }
  return info;
}

Reply<ServedFile> Results::file(std::string_view name, std::string_view path) {
  const auto nothing = [&] {
    return problem(404, "there is no file '" + std::string(path) + "' of a triangulation '" + std::string(name) + "'");
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

}  // namespace tessera
