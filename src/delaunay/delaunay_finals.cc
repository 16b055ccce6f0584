// The final cells of a reduced tile: stored early, kept in memory, or on scratch.
#include <span>
#include <utility>

#include "src/base/files/checksum.h"
#include "src/base/flat_codec.h"
#include "src/delaunay/delaunay_program.h"

namespace tessera {

// `at_once`: the tile is collected now, so finals need not go to scratch.
Status DelaunayProgram::keep_finals(FinalCells finals, const LoadedTile& loaded, bool at_once) {
  finals_ = std::make_unique<PendingFinals>();
  stored_early_ = {};
  if (early()) {
    auto sorted = std::make_shared<const EarlyFinals>(stage_.dimension, loaded.ids, std::move(finals),
                                                      stage_.early_unit, stage_.stop);
    *finals_ = sorted->left();
    if (sorted->early() > 0) {
      storing_ = stage_.store->store_early(self_, std::move(sorted));
    }
  } else {
    finals_->cells = std::move(finals);
  }
  return stage_.reduce && !at_once ? put_finals() : Status(success());
}

Status DelaunayProgram::put_aside() { return finals_ ? put_finals() : Status(success()); }

Status DelaunayProgram::await_stored() {
  if (!storing_.valid()) return success();
  auto stored = storing_.get();
  if (!stored) return stored.error();
  stored_early_ = std::move(stored).value();
  return success();
}

// Does not cover what the storage has returned for the early cells: the cells are the same, wherever they are stored.
std::uint64_t DelaunayProgram::sum_of(const PendingFinals& finals) {
  std::uint64_t sum = finals.early + std::uint64_t{1};
  for (const auto bytes : {std::as_bytes(std::span(finals.place)), std::as_bytes(std::span(finals.frozen)),
                           std::as_bytes(std::span(finals.cells.rows.data(), finals.cells.rows.size()))}) {
    sum = checksum(bytes, sum);
  }
  return sum;
}

Status DelaunayProgram::put_finals() {
  BOOST_OUTCOME_TRYV(await_stored());
  finals_sum_ = sum_of(*finals_);
  FlatWriter out;
  out.reserve(finals_->bytes() + stored_early_.size() + 64);
  out.value(finals_->early);
  out.list(finals_->place);
  out.list(finals_->frozen);
  out.list(finals_->cells.rows);
  out.list(stored_early_);
  finals_.reset();
  stored_early_ = {};
  return stage_.storage->write(self_, ScratchKind::finals, out.take());
}

bool DelaunayProgram::decode_finals(std::span<const std::byte> bytes) {
  auto finals = std::make_unique<PendingFinals>();
  FlatReader in(bytes);
  const bool read = in.value(finals->early) && in.list(finals->place) && in.list(finals->frozen) &&
                    in.list(finals->cells.rows) && in.list(stored_early_) && in.at_end();
  // The cells of another image of the same tile can be sound, but the kernel may not know them.
  if (!read || !finals->sound(stage_.dimension, own_points_) || sum_of(*finals) != finals_sum_) return false;
  finals_ = std::move(finals);
  return true;
}

// Restores the final cells of an earlier process, or of another node. Returns false when the tile cannot continue from
// them.
Result<bool> DelaunayProgram::restore_finals(std::span<const std::byte> bytes, bool at_once) {
  if (!decode_finals(bytes)) return false;
  // How final cells were stored depends on these options, and others may have been in force then.
  const bool placed = !finals_->place.empty() || finals_->early > 0;
  if (placed != early() && (placed || finals_->cells.rows.size() > 0)) return false;
  if (finals_->early > 0 && !stage_.store->take_early(self_, stored_early_)) return false;
  if (stage_.reduce && !at_once) {
    BOOST_OUTCOME_TRYV(put_finals());
  }
  return true;
}

Result<PendingFinals> DelaunayProgram::take_finals() {
  if (!finals_) {
    BOOST_OUTCOME_TRY(pieces, stage_.storage->read(self_, ScratchKind::finals));
    if (pieces.size() != 1 || !decode_finals(pieces[0])) return damaged(self_, "list of final cells");
  }
  PendingFinals taken = std::move(*finals_);
  finals_.reset();
  return taken;
}

}  // namespace tessera
