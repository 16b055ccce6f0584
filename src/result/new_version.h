// A change of a finished result. Whoever reads the result meanwhile is not disturbed, and whatever ends the writer
// leaves the old version or the new one.
//
//   begin  | takes the folder's lock; replaces the master file if the last writer was ended before it had; removes
//          | what writers that were ended have left, and files that only versions without a reader need
//   room   | is looked for, so that a disk that is too small is told before hours of work
//   tiles  | are new files, tiles/NNNNNN-V.vtu or .pts, which no manifest knows yet
//   commit | syncs the new files; gives the manifest of the old version a second name, .versions/NNNNNN.json; replaces
//          | manifest.json, and from then on the result is the new version; then replaces the master file, which
//          | follows from the manifest
//
// A reader holds a lock on the manifest that it has read (held_manifest.h), and whoever can lock the old manifest for
// itself knows that its version has no reader. Only the next writer removes files: programs that know nothing of locks
// have what they opened until then.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "src/base/files/folder_lock.h"
#include "src/base/files/temporary.h"
#include "src/base/result.h"
#include "src/result/store/tile_columns.h"
#include "src/result/store/tile_store.h"
#include "src/result/tile_source.h"

namespace tessera {

class NewVersion {
 public:
  // Errors: of TileSource::open(); usage when another process works in the folder, and for format 2; corrupt for a
  // damaged manifest of an older version that is read; io.
  static Result<std::unique_ptr<NewVersion>> begin(const std::filesystem::path& out);
  // Without commit() nothing of it stays.
  ~NewVersion();
  NewVersion(const NewVersion&) = delete;
  NewVersion& operator=(const NewVersion&) = delete;

  // The version that stands.
  const TileSource& source() const { return source_; }
  std::uint32_t number() const { return source_.manifest().version + 1; }
  // A folder for whatever must be put down meanwhile.
  const std::filesystem::path& scratch() const { return scratch_->path(); }
  // To be asked before anything is written: error io, with both figures, when there is no room for all tiles with these
  // columns and for `beside` bytes more. `free`: what known_free_bytes() tells of the folder. The old files stay, so
  // what the result takes now is needed once more.
  Status check_room(std::span<const ResultColumn> columns, std::uint64_t beside,
                    std::optional<std::uint64_t> free) const;

  // The tile with these columns more, which are the same in each. Safe to call from several threads for different
  // tiles. Errors: corrupt when the file is not the one that was stored; io, interrupted.
  Status add_columns(std::size_t index, std::span<const store::ColumnValues> columns, const std::stop_token& stop);
  // The tile is this file from then on, which moves; `entry`: of it. Safe to call likewise. Error io.
  Status replace_tile(std::size_t index, TileEntry entry, const std::filesystem::path& file);
  // `columns`: what they are. REQUIRES: if there are any, add_columns() was called for each tile. Tiles of which
  // nothing was said stay as they are. Errors: io; with it either version may stand.
  Status commit(std::vector<ResultColumn> columns);

 private:
  NewVersion(FolderLock lock, TileSource source) : lock_(std::move(lock)), source_(std::move(source)) {}
  Status mend_master() const;
  Status remove_unneeded() const;
  Status keep_old_manifest() const;

  FolderLock lock_;
  TileSource source_;
  std::optional<TemporaryFolder> scratch_;
  std::mutex mutex_;
  std::vector<TileEntry> written_;
  std::vector<TemporaryFile> files_;
};

}  // namespace tessera
