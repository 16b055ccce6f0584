// Changes a finished result. Programs that read the result meanwhile are not disturbed. When the writer is ended, by
// whatever cause, either the old version or the new one is left.
//
//   begin  | takes the folder's lock; replaces the master file if the last writer was ended before it did; removes what
//          | ended writers have left, and files that only versions need that are neither kept nor read
//   room   | is checked, so that a disk that is too small is reported before hours of work
//   tiles  | are new files, tiles/NNNNNN-V.vtu or .pts, which no manifest names yet; likewise new duplicates
//   commit | syncs the new files; gives the manifest of the old version a second name, .versions/NNNNNN.json; replaces
//          | the log of versions; replaces manifest.json, and from then on the result is the new version; then replaces
//          | the master file, which follows from the manifest
//
// A reader holds a lock on the manifest that it has read (held_manifest.h). A writer that can lock an old manifest for
// itself knows that no reader uses that version. Only the next writer removes files. So programs that do not know the
// locks keep what they have opened until the next change.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "src/base/files/folder_lock.h"
#include "src/base/files/temporary.h"
#include "src/base/result.h"
#include "src/result/store/tile_columns.h"
#include "src/result/store/tile_store.h"
#include "src/result/tile_source.h"
#include "src/result/version_log.h"

namespace tessera {

class DuplicateRowSort;  // src/result/store/duplicate_rows.h

struct VersionOptions {
  LockOptions lock = {};
  // How many of the newest versions stay readable, from now on; at least 1. Nothing: as many as before.
  std::optional<std::uint32_t> keep = {};
  // The caller has the log of a result that is kept in memory (src/delaunay/live).
  bool has_log = false;
  Periods periods = Periods::refused;  // of the result
};

// What a version says of itself in the log.
struct VersionNote {
  std::uint64_t added = 0, removed = 0;  // points
  std::vector<Manifest::Input> inputs = {};
  std::vector<std::string> command = {};
  std::string software_version = {};
};

// Replaces the master file of the result if it is that of the version before, because the last writer was ended before
// it did. Takes the folder's lock only for that. Errors: those of read_manifest(); usage when another process works in
// the folder; io.
Status mend_master(const std::filesystem::path& out, const LockOptions& lock = {});

class NewVersion {
 public:
  // Begins a change, and takes the folder's lock. Errors: those of TileSource::open(); usage when another process works
  // in the folder or keeps the result in memory, when a log has changes that are not stored, when the result has format
  // 2, or when the path names an older version; corrupt when the manifest of an older version, which a reader still
  // uses, or a log is damaged; io.
  static Result<std::unique_ptr<NewVersion>> begin(const std::filesystem::path& out,
                                                   const VersionOptions& options = {});
  // Removes everything that was written, unless commit() was called.
  ~NewVersion();
  NewVersion(const NewVersion&) = delete;
  NewVersion& operator=(const NewVersion&) = delete;

  // The version that is being changed.
  const TileSource& source() const { return source_; }
  std::uint32_t number() const { return source_.manifest().version + 1; }
  // A folder for scratch files. The destructor removes the folder.
  const std::filesystem::path& scratch() const { return scratch_->path(); }
  // Call this before anything is written. Error io, with both figures, when the disk has no room for all tiles with
  // these columns and for `beside` more bytes. `free` is what known_free_bytes() returned for the folder. The old files
  // stay, so the result needs as much room again as it takes now.
  Status check_room(std::span<const ResultColumn> columns, std::uint64_t beside,
                    std::optional<std::uint64_t> free) const;

  // Whether the version that is being changed has these columns already. Error usage when something else has one of
  // their names.
  Result<bool> has_columns(std::span<const ResultColumn> columns) const;

  // Writes a copy of a tile with these columns added. All tiles must get the same columns. Safe to call from several
  // threads for different tiles. Errors: corrupt when the file is not the one that was stored; io; interrupted.
  Status add_columns(std::size_t index, std::span<const store::ColumnValues> columns, const std::stop_token& stop);
  // Moves `file` into the result as the file of this tile; `entry` describes the file. Safe to call from several
  // threads for different tiles. Error io.
  Status replace_tile(std::size_t index, TileEntry entry, const std::filesystem::path& file);
  // The same for a tile that has no file yet. REQUIRES: the tile is none of the source.
  Status add_tile(TileEntry entry, const std::filesystem::path& file);
  // The new version does not have this tile.
  void remove_tile(std::size_t index);
  // The duplicates of the new version, ascending, and their attributes, if they are known. Without a call they stay as
  // they are. Error io.
  Status replace_duplicates(std::span<const DuplicatePair> pairs, DuplicateRowSort* rows = nullptr);
  // The manifest of the new version. Callers that change points set its bounds, inputs and numbers of points; they may
  // change the entries of tiles that stay. commit() sets all that follows from tiles, columns and duplicates.
  Manifest& manifest() { return next_; }
  // The tiles of the new version as they are so far, to be read before the new version is made.
  TileSource draft() const;
  // Makes the new version the current one. `columns` describes the columns that add_columns() has added. Tiles that
  // were neither extended nor replaced stay as they are. REQUIRES: if there are columns, add_columns() was called for
  // every tile. `before` gets the text of the new manifest when all other files have their places, and its error is
  // returned. Error io: the result may then be at either version.
  Status commit(std::vector<ResultColumn> columns, const VersionNote& note = {},
                const std::function<Status(const std::string& manifest)>& before = {});

 private:
  NewVersion(FolderLock lock, TileSource source)
      : lock_(std::move(lock)), source_(std::move(source)), next_(source_.manifest()) {}
  Status remove_unneeded() const;
  Status remove_unless(const std::set<std::filesystem::path>& needed) const;
  Status read_log(std::optional<std::uint32_t> keep);
  Status publish_tile(TileEntry entry, const std::filesystem::path& file);
  Status publish_file(TemporaryFile& temporary, const std::filesystem::path& final_name);
  Status bring_duplicates();
  Status bring(const std::filesystem::path& from, const std::filesystem::path& to);
  std::vector<TileEntry> tiles() const;
  void describe(std::vector<ResultColumn> columns);
  VersionEntry log_entry(const VersionNote& note) const;
  Status sync() const;
  Status keep_old_manifest() const;

  FolderLock lock_;
  TileSource source_;
  Manifest next_;
  VersionLog log_;
  std::optional<TemporaryFolder> scratch_;
  std::mutex mutex_;
  std::vector<TileEntry> written_;
  std::set<TileId> removed_;
  bool duplicates_replaced_ = false;
  std::vector<TemporaryFile> files_;
};

}  // namespace tessera
