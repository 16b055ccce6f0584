#include "src/exchange/settled_files.h"

#include <fcntl.h>

#include <cerrno>
#include <cstdint>
#include <string>
#include <system_error>
#include <utility>

#include "src/base/files/descriptor.h"
#include "src/base/files/folder.h"
#include "src/base/files/frame.h"
#include "src/base/files/names.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"

namespace tessera {

SettledFiles::SettledFiles(const std::filesystem::path& run, std::uint64_t seal, NodeId node)
    : folder_(scratch_folder(run, ScratchKind::settled)), own_(settled_file(run, node)), seal_(seal) {}

Status SettledFiles::append(TileId tile, std::span<const std::byte> bytes) {
  const std::lock_guard lock(mutex_);  // a write that was cut short is continued at the end of the file
  index_.reset();
  BOOST_OUTCOME_TRYV(make_directories(folder_));
  appended_ = true;
  return append_frame(own_, ScratchKind::settled, {seal_, tile.value}, bytes);
}

Status SettledFiles::sync() {
  const std::lock_guard lock(mutex_);
  if (!appended_) {  // an earlier process of this node may have appended
    BOOST_OUTCOME_TRY(there, is_there(own_));
    if (!there) return success();
  }
  BOOST_OUTCOME_TRYV(sync_files(std::span(&own_, 1)));
  return sync_folder(folder_);
}

Result<std::uint64_t> SettledFiles::bytes_there() const {
  std::uint64_t bytes = 0;
  FolderReader reader(folder_);
  while (const char* file = reader.next()) {
    if (!is_settled_name(file)) continue;
    // The file is opened for its size: a network file system answers from its cache, for a file that another machine
    // writes, until the file is opened.
    const FileHandle opened(::open((folder_ / file).c_str(), O_RDONLY | O_CLOEXEC));
    if (opened.get() < 0 && errno == ENOENT) continue;  // it was removed just now
    if (opened.get() < 0) return io_error(folder_ / file, "cannot be opened", errno);
    BOOST_OUTCOME_TRY(size, size_of(opened, folder_ / file));
    bytes += size;
  }
  if (reader.error() && reader.error() != std::errc::no_such_file_or_directory)
    return io_error(folder_, "cannot be read", reader.error().value());
  return bytes;
}

Result<SettledFiles::Index> SettledFiles::read_index() const {
  Index index;
  BOOST_OUTCOME_TRY(bytes, bytes_there());
  index.bytes = bytes;
  FolderReader reader(folder_);
  while (const char* file = reader.next()) {
    if (!is_settled_name(file)) continue;
    BOOST_OUTCOME_TRY(frames, frame_offsets(folder_ / file, ScratchKind::settled));
    for (const FrameOffset& frame : frames)
      index.frames[TileId{static_cast<std::uint32_t>(frame.owner.item)}] = {folder_ / file, frame.at};
  }
  if (reader.error() && reader.error() != std::errc::no_such_file_or_directory)
    return io_error(folder_, "cannot be read", reader.error().value());
  return index;
}

Result<std::optional<SettledFiles::StoredFrame>> SettledFiles::find(TileId tile) {
  const std::lock_guard lock(mutex_);
  bool old = !index_;
  if (index_ && !index_->frames.contains(tile)) {
    BOOST_OUTCOME_TRY(bytes, bytes_there());
    old = bytes != index_->bytes;
  }
  if (old) {
    BOOST_OUTCOME_TRY(index, read_index());
    index_ = std::move(index);
  }
  const auto found = index_->frames.find(tile);
  return found == index_->frames.end() ? std::optional<StoredFrame>() : found->second;
}

Result<bool> SettledFiles::has(TileId tile) {
  BOOST_OUTCOME_TRY(frame, find(tile));
  return frame.has_value();
}

Result<std::optional<BigVector<std::byte>>> SettledFiles::read(TileId tile) {
  BOOST_OUTCOME_TRY(frame, find(tile));
  if (!frame) return std::optional<BigVector<std::byte>>();
  BOOST_OUTCOME_TRY(payload, read_frame_at(frame->file, ScratchKind::settled, {seal_, tile.value}, frame->at));
  return std::optional(std::move(payload));
}

Status SettledFiles::clear() {
  const std::lock_guard lock(mutex_);
  index_.reset();
  return remove_whole(folder_);
}

}  // namespace tessera
