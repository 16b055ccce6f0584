#include "src/result/new_version.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "src/base/files/checksum.h"
#include "src/base/files/descriptor.h"
#include "src/base/files/folder.h"
#include "src/base/files/free_space.h"
#include "src/base/files/live_names.h"
#include "src/base/files/names.h"
#include "src/base/files/record_log.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/result/far_files.h"
#include "src/result/old_versions.h"
#include "src/result/store/duplicate_rows.h"
#include "src/result/store/duplicates.h"
#include "src/result/store/manifest.h"
#include "src/result/store/packed_array.h"
#include "src/result/store/period.h"
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

Result<Manifest> manifest_of(const result::OldVersion& old) {
  BOOST_OUTCOME_TRY(bytes, read_whole(old.file));
  return parse_manifest(old.file, bytes);
}

// With the list of duplicates, and relative to the result.
std::set<fs::path> file_names(const Manifest& manifest) {
  std::set<fs::path> names;
  for (const TileEntry& entry : manifest.tiles) names.insert(tile_file("", entry));
  if (manifest.duplicates_xxh3 != 0) names.insert(duplicates_of("", manifest));
  if (manifest.duplicate_rows_xxh3 != 0) names.insert(duplicate_rows_of("", manifest));
  return names;
}

bool is_of_tile(const fs::path& name) {
  return version_of_tile_file(name) || (is_tile_name(name) && (kind_of_tile_file(name) || is_temporary_name(name)));
}

bool is_of_duplicates(const fs::path& name) {
  const auto final_name = is_temporary_name(name) ? name.stem() : name;
  return is_duplicates_name(final_name) || is_duplicate_rows_name(final_name);
}

// The log of a result that is, or was, kept in memory may have changes that a version by others would not have.
Status check_nothing_unstored(const fs::path& out, std::uint32_t version) {
  const fs::path path = live_log_file(out, version);
  BOOST_OUTCOME_TRY(there, is_there(path));
  if (!there) return success();
  std::uint64_t records = 0;
  const auto count = [&](std::uint32_t, std::span<const std::byte>) -> Status {
    ++records;
    return success();
  };
  BOOST_OUTCOME_TRYV(RecordLog::open(path, count));
  if (records <= 1) return success();  // the first one says whose log it is
  return error(Errc::usage, path.string() +
                                ": this log has changes that are not stored, of a time when the result was kept in "
                                "memory; keep it in memory once more, so that they are stored, or move the log away if "
                                "the changes are not wanted");
}

// Whether the master file is that of the version before.
Result<bool> has_old_master(const fs::path& out, const Manifest& manifest) {
  if (!manifest.previous_master_xxh3) return false;
  BOOST_OUTCOME_TRY(sum, checksum_file(master_file(out)));
  return sum == *manifest.previous_master_xxh3 && sum != manifest.master_xxh3;
}

Status mend_master_of(const fs::path& out, const Manifest& manifest, const FolderLock& lock) {
  BOOST_OUTCOME_TRY(old, has_old_master(out, manifest));
  if (!old) return success();
  BOOST_OUTCOME_TRYV(lock.check());
  return write_whole(master_file(out), store::master_text(manifest));
}

std::int64_t now_in_seconds() {
  return std::chrono::duration_cast<std::chrono::seconds>(std::chrono::system_clock::now().time_since_epoch()).count();
}

}  // namespace

Status mend_master(const fs::path& out, const LockOptions& lock) {
  BOOST_OUTCOME_TRY(manifest, read_manifest(out));
  BOOST_OUTCOME_TRY(old, has_old_master(out, manifest));
  if (!old) return success();
  BOOST_OUTCOME_TRY(locked, FolderLock::take(out, lock));
  BOOST_OUTCOME_TRY(current, read_manifest(out));  // another writer may have come in between
  return mend_master_of(out, current, locked);
}

Result<std::unique_ptr<NewVersion>> NewVersion::begin(const fs::path& out, const VersionOptions& options) {
  if (named_version(out))
    return error(Errc::usage, out.string() + ": is a version of a result; only the newest version can be changed");
  BOOST_OUTCOME_TRYV(result::refuse_far(out));
  BOOST_OUTCOME_TRY(there, is_there(manifest_file(out)));
  if (!there) return no_manifest(out);
  BOOST_OUTCOME_TRY(lock, FolderLock::take(out, options.lock));
  BOOST_OUTCOME_TRY(source, TileSource::open(out, options.periods));
  if (source.manifest().format_version < unchanged_format)
    return error(Errc::usage, out.string() + ": is of format version " +
                                  std::to_string(source.manifest().format_version) +
                                  ", which is read and not changed; triangulate again");
  if (!options.has_log) {
    BOOST_OUTCOME_TRYV(check_nothing_unstored(out, source.manifest().version));
  }
  std::unique_ptr<NewVersion> made(new NewVersion(std::move(lock), std::move(source)));
  BOOST_OUTCOME_TRYV(made->read_log(options.keep));
  // Before anything is removed that an old master file refers to.
  BOOST_OUTCOME_TRYV(mend_master_of(out, made->source_.manifest(), made->lock_));
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

// The first change of a result makes an entry of the version before, too.
Status NewVersion::read_log(std::optional<std::uint32_t> keep) {
  const fs::path& out = source_.folder();
  BOOST_OUTCOME_TRY(log, read_version_log(out, source_.manifest().version));
  log_ = std::move(log);
  if (keep) log_.keep = std::max(*keep, 1u);
  if (!log_.versions.empty() && log_.versions.back().version == source_.manifest().version) return success();
  BOOST_OUTCOME_TRY(status, look_at(manifest_file(out)));
  append(log_, entry_of(source_.manifest(), status ? static_cast<std::int64_t>(status->st_mtim.tv_sec) : 0));
  return success();
}

Status NewVersion::remove_unneeded() const {
  const fs::path& out = source_.folder();
  const std::uint32_t current = source_.manifest().version;
  std::set<fs::path> needed = file_names(source_.manifest());
  std::vector<Unread> unread;
  BOOST_OUTCOME_TRY(olds, result::old_versions(out));
  for (const auto& old : olds) {
    if (old.version >= current) {  // left by a writer that was ended
      BOOST_OUTCOME_TRYV(remove_file(old.file));
      continue;
    }
    if (current - old.version >= log_.keep) {
      BOOST_OUTCOME_TRY(locked, lock_if_unread(old));
      if (locked) {
        unread.push_back(std::move(*locked));
        continue;
      }
    }
    BOOST_OUTCOME_TRY(manifest, manifest_of(old));
    needed.merge(file_names(manifest));
  }
  BOOST_OUTCOME_TRYV(remove_unless(needed));
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

// Removes files of tiles and of duplicates that no version needs.
Status NewVersion::remove_unless(const std::set<fs::path>& needed) const {
  const fs::path& out = source_.folder();
  const auto folder = tiles_folder(out);
  BOOST_OUTCOME_TRY(with_tiles, is_folder(folder));
  std::vector<fs::path> files;
  if (with_tiles) {
    BOOST_OUTCOME_TRY(names, sorted_names(folder));
    for (const std::string& name : names) {
      if (is_of_tile(name)) files.push_back(tiles_folder("") / name);
    }
  }
  BOOST_OUTCOME_TRY(names, sorted_names(out));
  for (const std::string& name : names) {
    if (is_of_duplicates(name)) files.emplace_back(name);
  }
  for (const fs::path& file : files) {
    if (needed.contains(file)) continue;
    BOOST_OUTCOME_TRYV(lock_.heard());
    BOOST_OUTCOME_TRYV(remove_file(out / file));
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

Result<bool> NewVersion::has_columns(std::span<const ResultColumn> columns) const {
  const Manifest& manifest = source_.manifest();
  const auto is_there = [&](const ResultColumn& wanted) {
    return std::ranges::any_of(manifest.columns, [&](const ResultColumn& one) {
      return one.name == wanted.name && one.of_cells == wanted.of_cells;
    });
  };
  if (std::ranges::all_of(columns, is_there)) return true;
  const std::string out = source_.folder().string();
  for (const ResultColumn& column : columns) {
    const auto same_name = [&](const auto& other) { return other.name == column.name; };
    if (!column.of_cells && std::ranges::any_of(manifest.schema, same_name))
      return error(Errc::usage, out + ": its vertices have an attribute '" + column.name +
                                    "' already; triangulate without it, or under another name");
    if (std::ranges::any_of(manifest.columns, same_name))
      return error(Errc::usage, out + ": has a column '" + column.name + "' already");
  }
  return false;
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
  return publish_tile(std::move(entry), file);
}

Status NewVersion::add_tile(TileEntry entry, const fs::path& file) { return publish_tile(std::move(entry), file); }

Status NewVersion::publish_tile(TileEntry entry, const fs::path& file) {
  entry.version = number();
  const auto final_name = tile_file(source_.folder(), entry);
  BOOST_OUTCOME_TRYV(lock_.heard());
  BOOST_OUTCOME_TRYV(rename_file(file, final_name));
  const std::lock_guard lock(mutex_);
  files_.emplace_back(final_name);
  written_.push_back(std::move(entry));
  return success();
}

void NewVersion::remove_tile(std::size_t index) {
  const std::lock_guard lock(mutex_);
  removed_.insert(source_.entry(index).tile);
}

Status NewVersion::replace_duplicates(std::span<const DuplicatePair> pairs, DuplicateRowSort* rows) {
  const fs::path& out = source_.folder();
  next_.format_version = updated_format;
  next_.duplicates = pairs.size();
  next_.duplicates_xxh3 = next_.duplicate_rows_xxh3 = 0;
  duplicates_replaced_ = true;
  if (pairs.empty()) return success();
  TemporaryFile of_pairs(temporary_name_of_process(duplicates_file(out)));
  BOOST_OUTCOME_TRY(written, store::write_pairs(of_pairs.path(), duplicates_file(out), pairs));
  next_.duplicates_xxh3 = written.xxh3;
  BOOST_OUTCOME_TRYV(publish_file(of_pairs, duplicates_of(out, next_)));
  if (rows == nullptr) return success();
  TemporaryFile of_rows(temporary_name_of_process(duplicate_rows_file(out)));
  BOOST_OUTCOME_TRY(xxh3, store::write_rows(of_rows.path(), duplicate_rows_file(out), *rows, pairs.size()));
  next_.duplicate_rows_xxh3 = xxh3;
  return publish_file(of_rows, duplicate_rows_of(out, next_));
}

// An equal file may exist already, as that of an older version.
Status NewVersion::publish_file(TemporaryFile& temporary, const fs::path& final_name) {
  BOOST_OUTCOME_TRY(there, is_there(final_name));
  if (there) return success();
  BOOST_OUTCOME_TRYV(lock_.heard());
  BOOST_OUTCOME_TRYV(rename_file(temporary.path(), final_name));
  temporary.keep();
  files_.emplace_back(final_name);
  return success();
}

// The files of an older format have other names.
Status NewVersion::bring_duplicates() {
  const fs::path& out = source_.folder();
  const Manifest& old = source_.manifest();
  if (duplicates_replaced_) return success();
  if (old.duplicates_xxh3 != 0) {
    BOOST_OUTCOME_TRYV(bring(duplicates_of(out, old), duplicates_of(out, next_)));
  }
  if (old.duplicate_rows_xxh3 == 0) return success();
  return bring(duplicate_rows_of(out, old), duplicate_rows_of(out, next_));
}

Status NewVersion::bring(const fs::path& from, const fs::path& to) {
  BOOST_OUTCOME_TRY(there, is_there(to));
  if (there) return success();
  if (::link(from.c_str(), to.c_str()) != 0) {
    BOOST_OUTCOME_TRY(bytes, read_whole(from));
    BOOST_OUTCOME_TRYV(write_whole(to, bytes));
  }
  files_.emplace_back(to);
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

// Those that stay, and those that were written.
std::vector<TileEntry> NewVersion::tiles() const {
  std::map<TileId, TileEntry> tiles;
  for (const TileEntry& entry : next_.tiles) {
    if (!removed_.contains(entry.tile)) tiles[entry.tile] = entry;
  }
  for (const TileEntry& entry : written_) tiles[entry.tile] = entry;
  std::vector<TileEntry> all;
  for (auto& [tile, entry] : tiles) all.push_back(std::move(entry));
  return all;
}

TileSource NewVersion::draft() const {
  Manifest manifest = next_;
  manifest.tiles = tiles();
  return TileSource::draft(source_.folder(), std::move(manifest));
}

// Sets what follows from tiles and columns.
void NewVersion::describe(std::vector<ResultColumn> columns) {
  next_.tiles = tiles();
  next_.vertices = next_.cells = 0;
  for (const TileEntry& entry : next_.tiles) {
    next_.vertices += entry.own_points;
    next_.cells += entry.main_cells;
  }
  next_.digest = sum_of_digests(next_.tiles);
  next_.format_version = std::max(next_.format_version, changed_format);
  next_.version = number();
  for (auto& column : columns) {
    column.version = next_.version;
    if (!column.of_cells) next_.schema.push_back({column.name, column.type});
    next_.columns.push_back(std::move(column));
  }
  next_.previous_master_xxh3 = next_.master_xxh3;
  const std::string master = store::master_text(next_);
  next_.master_xxh3 = checksum(std::as_bytes(std::span(master)));
}

VersionEntry NewVersion::log_entry(const VersionNote& note) const {
  VersionEntry entry = entry_of(next_, now_in_seconds());
  entry.added = note.added;
  entry.removed = note.removed;
  entry.input_files = note.inputs.size();
  for (const auto& input : note.inputs) entry.inputs.push_back(input.path);
  entry.command = note.command;
  entry.software_version = note.software_version;
  return entry;
}

// The new files, so that they are on the disk before a manifest names them.
Status NewVersion::sync() const {
  if (files_.empty()) return success();
  std::vector<fs::path> files;
  for (const auto& file : files_) files.push_back(file.path());
  BOOST_OUTCOME_TRYV(sync_files(files));
  BOOST_OUTCOME_TRYV(sync_folder(tiles_folder(source_.folder())));
  return sync_folder(source_.folder());
}

Status NewVersion::commit(std::vector<ResultColumn> columns, const VersionNote& note,
                          const std::function<Status(const std::string& manifest)>& before) {
  const fs::path& out = source_.folder();
  if (!columns.empty() && written_.size() != source_.tiles()) return error(Errc::internal, "a version lacks tiles");
  if (has_lists_of_versions(next_.format_version)) {
    BOOST_OUTCOME_TRYV(bring_duplicates());
  }
  describe(std::move(columns));
  append(log_, log_entry(note));
  BOOST_OUTCOME_TRYV(sync());
  BOOST_OUTCOME_TRYV(lock_.check());
  BOOST_OUTCOME_TRYV(keep_old_manifest());
  BOOST_OUTCOME_TRYV(lock_.check());
  BOOST_OUTCOME_TRYV(write_whole(version_log_file(out), version_log_text(log_)));
  BOOST_OUTCOME_TRYV(lock_.check());
  const std::string text = store::manifest_to_text(next_);
  if (before) {
    BOOST_OUTCOME_TRYV(before(text));
  }
  for (auto& file : files_) file.keep();  // an error from here on may come too late to undo the change
  BOOST_OUTCOME_TRYV(write_whole(manifest_file(out), text));
  BOOST_OUTCOME_TRYV(lock_.check());
  return write_whole(master_file(out), store::master_text(next_));
}

}  // namespace tessera
