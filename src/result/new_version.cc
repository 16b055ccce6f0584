#include "src/result/new_version.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <set>
#include <string>
#include <system_error>
#include <utility>

#include "src/base/files/checksum.h"
#include "src/base/files/descriptor.h"
#include "src/base/files/folder.h"
#include "src/base/files/free_space.h"
#include "src/base/files/names.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/result/old_versions.h"
#include "src/result/store/manifest.h"
#include "src/result/store/packed_array.h"
#include "src/result/store/vtk_xml.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

// An old version without readers. It stays locked until it is removed, so that no reader begins to use it.
struct Unread {
  fs::path file;
  FileHandle lock;
};

// Returns nothing when the version has readers, or when that cannot be known.
Result<std::optional<Unread>> lock_if_unread(const result::OldVersion& old) {
  if (old.copy) return std::optional<Unread>{};
  BOOST_OUTCOME_TRY(file, open_handle(old.file, O_RDWR));  // network file systems ask for the right to write
  if (::flock(file.get(), LOCK_EX | LOCK_NB) != 0) return std::optional<Unread>{};
  return std::optional(Unread{old.file, std::move(file)});
}

Result<std::set<fs::path>> tile_names_of(const result::OldVersion& old) {
  BOOST_OUTCOME_TRY(bytes, read_whole(old.file));
  BOOST_OUTCOME_TRY(manifest, parse_manifest(old.file, bytes));
  return result::tile_names(manifest);
}

bool is_tile_of_result(const fs::path& name) {
  return version_of_tile_file(name) || (is_tile_name(name) && kind_of_tile_file(name));
}

}  // namespace

Result<std::unique_ptr<NewVersion>> NewVersion::begin(const fs::path& out, const LockOptions& options) {
  BOOST_OUTCOME_TRY(there, is_there(manifest_file(out)));
  if (!there) return no_manifest(out);
  BOOST_OUTCOME_TRY(lock, FolderLock::take(out, options));
  BOOST_OUTCOME_TRY(source, TileSource::open(out));
  if (source.manifest().format_version < unchanged_format)
    return error(Errc::usage, out.string() + ": is of format version " +
                                  std::to_string(source.manifest().format_version) +
                                  ", which is read and not changed; triangulate again");
  std::unique_ptr<NewVersion> made(new NewVersion(std::move(lock), std::move(source)));
  BOOST_OUTCOME_TRYV(made->mend_master());
  BOOST_OUTCOME_TRYV(made->remove_unneeded());
  BOOST_OUTCOME_TRYV(make_directories(versions_folder(out)));
  BOOST_OUTCOME_TRYV(remove_whole(pass_folder(out)));
  BOOST_OUTCOME_TRY(scratch, TemporaryFolder::make(pass_folder(out)));
  made->scratch_.emplace(std::move(scratch));
  return made;
}

NewVersion::~NewVersion() {
  scratch_.reset();
  ::rmdir(versions_folder(source_.folder()).c_str());  // fails, as it should, while older versions are in it
}

// Called before anything is removed that the old master file refers to.
Status NewVersion::mend_master() const {
  const Manifest& manifest = source_.manifest();
  const auto path = master_file(source_.folder());
  if (!manifest.previous_master_xxh3) return success();
  BOOST_OUTCOME_TRY(sum, checksum_file(path));
  if (sum != *manifest.previous_master_xxh3 || sum == manifest.master_xxh3) return success();
  BOOST_OUTCOME_TRYV(lock_.check());
  return write_whole(path, store::master_text(manifest));
}

Status NewVersion::remove_unneeded() const {
  const fs::path& out = source_.folder();
  std::set<fs::path> needed = result::tile_names(source_.manifest());
  std::vector<Unread> unread;
  BOOST_OUTCOME_TRY(olds, result::old_versions(out));
  for (const auto& old : olds) {
    if (old.version >= source_.manifest().version) {  // left by a writer that was ended
      BOOST_OUTCOME_TRYV(remove_file(old.file));
      continue;
    }
    BOOST_OUTCOME_TRY(locked, lock_if_unread(old));
    if (locked) {
      unread.push_back(std::move(*locked));
      continue;
    }
    BOOST_OUTCOME_TRY(names, tile_names_of(old));
    needed.merge(names);
  }
  const auto folder = tiles_folder(out);
  BOOST_OUTCOME_TRY(with_tiles, is_folder(folder));
  if (with_tiles) {
    BOOST_OUTCOME_TRY(names, sorted_names(folder));
    for (const std::string& name : names) {
      if (needed.contains(name) || !(is_tile_of_result(name) || (is_tile_name(name) && is_temporary_name(name))))
        continue;
      BOOST_OUTCOME_TRYV(lock_.heard());
      BOOST_OUTCOME_TRYV(remove_file(folder / name));
    }
  }
  for (const auto& old : unread) {
    BOOST_OUTCOME_TRYV(remove_file(old.file));
  }
  const auto versions = versions_folder(out);
  BOOST_OUTCOME_TRY(with_versions, is_folder(versions, FollowLinks::no));
  if (!with_versions) return success();
  BOOST_OUTCOME_TRY(names, sorted_names(versions));
  for (const std::string& name : names) {
    if (!is_temporary_name(name)) continue;
    BOOST_OUTCOME_TRYV(remove_file(versions / name));
  }
  return success();
}

Status NewVersion::check_room(std::span<const ResultColumn> columns, std::uint64_t beside,
                              std::optional<std::uint64_t> free) const {
  // What each tile needs besides its arrays: its lines in the manifest and in the master file, a longer header, and the
  // rest of the last disk block of its file and of its scratch file. Files of points hold packed values, which need no
  // more room than plain ones.
  constexpr std::uint64_t of_a_tile = 16 << 10;
  std::uint64_t needed = beside + of_a_tile;
  for (const TileEntry& entry : source_.manifest().tiles) {
    needed += entry.bytes + of_a_tile;
    for (const auto& column : columns) {
      const std::uint64_t bytes = (column.of_cells ? entry.cells : entry.points) * size_of(column.type);
      needed += store::table_bytes(store::block_count(bytes)) + store::plain_bytes(bytes);
    }
  }
  return tessera::check_room(source_.folder(), "a new version, beside the one that stands,", needed, free);
}

Status NewVersion::add_columns(std::size_t index, std::span<const store::ColumnValues> columns,
                               const std::stop_token& stop) {
  TileEntry entry = source_.entry(index);
  BOOST_OUTCOME_TRYV(source_.check(index));
  entry.version = number();
  const auto final_name = tile_file(source_.folder(), entry);
  TemporaryFile temporary(temporary_name_of_process(final_name));
  const store::TileCopy copy{
      .tile = entry.tile, .from = source_.file(index), .to = temporary.path(), .final_name = final_name};
  BOOST_OUTCOME_TRY(written, entry.kind == TileKind::points ? store::copy_points_with_columns(copy, columns, stop)
                                                            : store::copy_with_columns(copy, columns, stop));
  entry.bytes = written.bytes;
  entry.xxh3 = written.xxh3;
  BOOST_OUTCOME_TRYV(lock_.heard());
  BOOST_OUTCOME_TRYV(rename_file(temporary.path(), final_name));
  temporary.keep();
  const std::lock_guard lock(mutex_);
  files_.emplace_back(final_name);
  written_.push_back(entry);
  return success();
}

Status NewVersion::replace_tile(std::size_t index, TileEntry entry, const fs::path& file) {
  entry.tile = source_.entry(index).tile;
  entry.version = number();
  const auto final_name = tile_file(source_.folder(), entry);
  BOOST_OUTCOME_TRYV(lock_.heard());
  BOOST_OUTCOME_TRYV(rename_file(file, final_name));
  const std::lock_guard lock(mutex_);
  files_.emplace_back(final_name);
  written_.push_back(std::move(entry));
  return success();
}

// Gives the old manifest a second name. A new file would not do: readers of the old version hold a lock on this inode.
Status NewVersion::keep_old_manifest() const {
  const fs::path& out = source_.folder();
  const std::uint32_t version = source_.manifest().version;
  const auto path = version_file(out, version);
  BOOST_OUTCOME_TRYV(remove_file(path));
  if (::link(manifest_file(out).c_str(), path.c_str()) != 0) {
    const int reason = errno;
    if (reason != EPERM && reason != EOPNOTSUPP && reason != ENOSYS && reason != EMLINK)
      return io_error(path, "cannot be made", reason);
    BOOST_OUTCOME_TRY(bytes, read_whole(manifest_file(out)));
    BOOST_OUTCOME_TRYV(write_whole(version_copy(out, version), bytes));
  }
  BOOST_OUTCOME_TRYV(sync_folder(versions_folder(out)));
  return sync_folder(out);
}

Status NewVersion::commit(std::vector<ResultColumn> columns) {
  const fs::path& out = source_.folder();
  Manifest next = source_.manifest();
  if (!columns.empty() && written_.size() != next.tiles.size()) return error(Errc::internal, "a version lacks tiles");
  for (const TileEntry& entry : written_) next.tiles[*source_.find(entry.tile)] = entry;
  next.format_version = changed_format;
  next.version = number();
  for (auto& column : columns) {
    column.version = next.version;
    if (!column.of_cells) next.schema.push_back({column.name, column.type});
    next.columns.push_back(std::move(column));
  }
  next.previous_master_xxh3 = next.master_xxh3;
  const std::string master = store::master_text(next);
  next.master_xxh3 = checksum(std::as_bytes(std::span(master)));

  std::vector<fs::path> files;
  for (const auto& file : files_) files.push_back(file.path());
  BOOST_OUTCOME_TRYV(sync_files(files));
  if (!files.empty()) {
    BOOST_OUTCOME_TRYV(sync_folder(tiles_folder(out)));
  }
  BOOST_OUTCOME_TRYV(lock_.check());
  BOOST_OUTCOME_TRYV(keep_old_manifest());
  BOOST_OUTCOME_TRYV(lock_.check());
  for (auto& file : files_) file.keep();  // an error from here on may come too late to undo the change
  BOOST_OUTCOME_TRYV(write_whole(manifest_file(out), store::manifest_to_text(next)));
  BOOST_OUTCOME_TRYV(lock_.check());
  return write_whole(master_file(out), master);
}

}  // namespace tessera
