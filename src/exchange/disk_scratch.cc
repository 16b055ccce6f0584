#include "src/exchange/disk_scratch.h"

#include <utility>

#include "src/base/files/folder.h"
#include "src/base/files/folder_lock.h"
#include "src/base/files/handed_file.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"

namespace tessera {
namespace {

Result<TileStorage::Pieces> pieces_of(const std::filesystem::path& file, ScratchKind kind, const FrameOwner& owner) {
  TileStorage::Pieces pieces;
  BOOST_OUTCOME_TRY(there, is_there(file));
  if (!there) return pieces;
  BOOST_OUTCOME_TRYV(for_each_frame(file, kind, owner, [&](BigVector<std::byte> payload) -> Status {
    pieces.push_back(std::move(payload));
    return success();
  }));
  return pieces;
}

}  // namespace

DiskScratch::DiskScratch(DiskScratchOptions options)
    : options_(std::move(options)), settled_(options_.shared, options_.seal, options_.node) {}

const std::filesystem::path& DiskScratch::folder_of(ScratchKind what) const {
  // The duplicates of all nodes are gathered at the end.
  return what == ScratchKind::duplicates ? options_.shared : options_.own;
}

template <class Outcome>
Outcome DiskScratch::on(ScratchKind what, Outcome outcome) {
  if (!outcome && outcome.error().code == Errc::io && folder_of(what) != options_.shared) own_scratch_failed_ = true;
  return outcome;
}

Status DiskScratch::write(TileId tile, ScratchKind what, std::span<const std::byte> bytes) {
  BOOST_OUTCOME_TRYV(check_held(options_.lock_file));
  if (what == ScratchKind::settled) return settled_.append(tile, bytes);
  const auto path = scratch_file(folder_of(what), what, tile);
  BOOST_OUTCOME_TRYV(on(what, make_directories(path.parent_path())));
  return on(what, write_frame(path, what, owner_of(tile), bytes));
}

Status DiskScratch::hand_over(TileId tile, std::span<const std::byte> bytes) {
  BOOST_OUTCOME_TRYV(check_held(options_.lock_file));
  const auto path = handed_file(options_.shared, tile);
  BOOST_OUTCOME_TRYV(make_directories(path.parent_path()));
  return write_frame(path, ScratchKind::state, owner_of(tile), bytes);
}

Result<TileStorage::Pieces> DiskScratch::handed(TileId tile) {
  return pieces_of(handed_file(options_.shared, tile), ScratchKind::state, owner_of(tile));
}

Status DiskScratch::forget_handed(TileId tile) { return remove_file(handed_file(options_.shared, tile)); }

Status DiskScratch::append(TileId tile, ScratchKind what, std::span<const std::byte> bytes) {
  BOOST_OUTCOME_TRYV(check_held(options_.lock_file));
  const auto path = scratch_file(folder_of(what), what, tile);
  BOOST_OUTCOME_TRYV(on(what, make_directories(path.parent_path())));
  return on(what, append_frame(path, what, owner_of(tile), bytes));
}

Result<bool> DiskScratch::has(TileId tile, ScratchKind what) {
  if (what == ScratchKind::settled) return settled_.has(tile);
  return on(what, is_there(scratch_file(folder_of(what), what, tile)));
}

Result<TileStorage::Pieces> DiskScratch::read(TileId tile, ScratchKind what) {
  Pieces pieces;
  if (what == ScratchKind::settled) {
    BOOST_OUTCOME_TRY(bytes, settled_.read(tile));
    if (bytes) pieces.push_back(std::move(*bytes));
    return pieces;
  }
  return on(what, pieces_of(scratch_file(folder_of(what), what, tile), what, owner_of(tile)));
}

Status DiskScratch::remove(TileId tile, ScratchKind what) {
  BOOST_OUTCOME_TRYV(check_held(options_.lock_file));
  return on(what, remove_file(scratch_file(folder_of(what), what, tile)));
}

Status DiskScratch::clear(ScratchKind what) {
  BOOST_OUTCOME_TRYV(check_held(options_.lock_file));
  if (what == ScratchKind::settled) return settled_.clear();
  return on(what, remove_whole(scratch_folder(folder_of(what), what)));
}

}  // namespace tessera
