#include "src/delaunay/tile_finals.h"

#include <chrono>
#include <utility>

#include "src/base/files/checksum.h"
#include "src/base/flat_codec.h"
#include "src/tiling/tile/early_finals.h"

namespace tessera {

void TileFinals::clear() {
  finals_.reset();  // may be left from an image that could not be restored
  stored_early_ = {};
  sum_ = 0;
}

Status TileFinals::keep(FinalCells finals, std::span<const PointId> ids, bool at_once) {
  finals_ = std::make_unique<PendingFinals>();
  stored_early_ = {};
  if (stage_.stores_early(ids.size())) {
    auto sorted =
        std::make_shared<const EarlyFinals>(stage_.dimension, ids, std::move(finals), stage_.early_unit, stage_.stop);
    *finals_ = sorted->left();
    if (sorted->early() > 0) {
      storing_ = stage_.store->store_early(self_, std::move(sorted));
    }
  } else {
    finals_->cells = std::move(finals);
  }
  return stage_.reduce && !at_once ? put_aside() : Status(success());
}

Status TileFinals::stored_so_far() {
  if (!storing_.valid() || storing_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return success();
  return await_stored();
}

Status TileFinals::await_stored() {
  if (!storing_.valid()) return success();
  auto stored = storing_.get();
  if (!stored) return stored.error();
  stored_early_ = std::move(stored).value();
  return success();
}

Result<BigVector<std::byte>> TileFinals::take_stored() {
  BOOST_OUTCOME_TRYV(await_stored());
  return std::move(stored_early_);
}

// Does not cover what the storage has returned for the early cells: the cells are the same, wherever they are stored.
std::uint64_t TileFinals::sum_of(const PendingFinals& finals) {
  std::uint64_t sum = finals.early + std::uint64_t{1};
  for (const auto bytes : {std::as_bytes(std::span(finals.mesh_index)), std::as_bytes(std::span(finals.frozen)),
                           std::as_bytes(std::span(finals.cells.rows.data(), finals.cells.rows.size()))}) {
    sum = checksum(bytes, sum);
  }
  return sum;
}

Status TileFinals::put_aside() {
  if (!finals_) return success();
  BOOST_OUTCOME_TRYV(await_stored());
  sum_ = sum_of(*finals_);
  FlatWriter out;
  out.reserve(finals_->bytes() + stored_early_.size() + 64);
  out.value(finals_->early);
  out.list(finals_->mesh_index);
  out.list(finals_->frozen);
  out.list(finals_->cells.rows);
  out.list(stored_early_);
  finals_.reset();
  stored_early_ = {};
  return stage_.storage->write(self_, ScratchKind::finals, out.take());
}

bool TileFinals::decode(std::span<const std::byte> bytes, std::uint64_t own_points) {
  auto finals = std::make_unique<PendingFinals>();
  FlatReader in(bytes);
  const bool read = in.value(finals->early) && in.list(finals->mesh_index) && in.list(finals->frozen) &&
                    in.list(finals->cells.rows) && in.list(stored_early_) && in.at_end();
  // The cells of another image of the same tile can be sound, but the kernel may not know them.
  if (!read || !finals->sound(stage_.dimension, own_points) || sum_of(*finals) != sum_) return false;
  finals_ = std::move(finals);
  return true;
}

Result<bool> TileFinals::restore(std::span<const std::byte> bytes, std::uint64_t own_points, bool at_once) {
  if (!decode(bytes, own_points)) return false;
  // How final cells were stored depends on these options, and others may have been in force then.
  const bool placed = !finals_->mesh_index.empty() || finals_->early > 0;
  if (placed != stage_.stores_early(own_points) && (placed || finals_->cells.rows.size() > 0)) return false;
  if (finals_->early > 0 && !stage_.store->take_early(self_, stored_early_)) return false;
  if (stage_.reduce && !at_once) {
    BOOST_OUTCOME_TRYV(put_aside());
  }
  return true;
}

Result<PendingFinals> TileFinals::take(std::uint64_t own_points) {
  if (!finals_) {
    BOOST_OUTCOME_TRY(pieces, stage_.storage->read(self_, ScratchKind::finals));
    if (pieces.size() != 1 || !decode(pieces[0], own_points)) return damaged(self_, "list of final cells");
  }
  PendingFinals taken = std::move(*finals_);
  finals_.reset();
  return taken;
}

}  // namespace tessera
