// A tile that is not in memory: its image on scratch, and the way back from it, in the same process or another one.
#include <cstring>
#include <span>
#include <utility>

#include "src/base/check.h"
#include "src/run/tile_state.h"

namespace tessera {

Status TileState::sleep() {
  check(phase_ == Phase::awake, "only a tile that is awake falls asleep");
  if (finals_) {
    BOOST_OUTCOME_TRYV(put_finals());
  }
  if (!imaged_) {
    BOOST_OUTCOME_TRY(bytes, image());
    BOOST_OUTCOME_TRYV(context_.storage->write(self_.tile, ScratchKind::state, bytes));
    imaged_ = true;
    earlier_ = false;
  }
  triangulation_.reset();
  points_.reset();
  counters_.trim();  // there are many tiles asleep
  phase_ = Phase::asleep;
  return success();
}

Result<BigVector<std::byte>> TileState::image() {
  if (phase_ == Phase::asleep) {
    BOOST_OUTCOME_TRY(pieces, context_.storage->read(self_.tile, ScratchKind::state));
    if (pieces.size() != 1) return damaged("image");
    return std::move(pieces[0]);
  }
  BigVector<std::byte> bytes = triangulation_->save();
  const ImageEnd end{own_points_, finals_sum_};
  const auto last = std::as_bytes(std::span(&end, 1));
  bytes.insert(bytes.end(), last.begin(), last.end());
  return bytes;
}

// Null when the bytes are not what image() has made.
std::unique_ptr<TileTriangulation> TileState::load_image(BigVector<std::byte> bytes, ImageEnd& end) const {
  if (bytes.size() < sizeof end) return nullptr;
  std::memcpy(&end, bytes.data() + bytes.size() - sizeof end, sizeof end);
  bytes.resize(bytes.size() - sizeof end);
  auto tile = std::make_unique<TileTriangulation>(options());
  if (!tile->load(std::move(bytes))) return nullptr;
  return tile;
}

Status TileState::wake() {
  if (phase_ == Phase::awake) return success();
  check(phase_ == Phase::asleep, "only a tile that sleeps is woken");
  BOOST_OUTCOME_TRY(pieces, context_.storage->read(self_.tile, ScratchKind::state));
  if (pieces.size() != 1) return damaged("image");
  ImageEnd end;
  triangulation_ = load_image(std::move(pieces[0]), end);
  if (!triangulation_ || end.own_points != own_points_ || end.finals_sum != finals_sum_) return damaged("image");
  read_back_ = true;
  if (earlier_) triangulation_->forget_words();
  if (!triangulation_->reduced()) {
    BOOST_OUTCOME_TRY(loaded, context_.storage->load_points(self_.tile));
    points_ = std::make_unique<LoadedTile>(std::move(loaded));
  }
  phase_ = Phase::awake;
  return success();
}

// An image is a right beginning whatever the other tiles begin from, if all it has ever told is told again. What was
// told to it since, those tell again who remember it: they begin from images, too, or have not told it yet.
Result<bool> TileState::restore(bool at_once) {
  auto pieces = context_.storage->read(self_.tile, ScratchKind::state);
  // Damaged, or written by another version: the tile is built again.
  if (!pieces || pieces.value().size() != 1) return false;
  ImageEnd end;
  auto tile = load_image(std::move(pieces.value()[0]), end);
  if (!tile) return false;
  own_points_ = end.own_points;
  finals_sum_ = end.finals_sum;
  if (tile->handed_out()) {
    auto finals = context_.storage->read(self_.tile, ScratchKind::finals);
    if (!finals || finals.value().size() != 1) return false;
    BOOST_OUTCOME_TRY(sound, restore_finals(finals.value()[0], at_once));
    if (!sound) return false;
  }
  triangulation_ = std::move(tile);
  BOOST_OUTCOME_TRYV(go_on_from_image());
  imaged_ = earlier_ = true;
  return true;
}

Status TileState::go_on_from_image() {
  read_back_ = true;
  if (!triangulation_->reduced()) {
    BOOST_OUTCOME_TRY(loaded, context_.storage->load_points(self_.tile));
    points_ = std::make_unique<LoadedTile>(std::move(loaded));
    if (points_->points.size() != own_points_) return damaged("file of points");
  }
  triangulation_->replay();
  return success();
}

}  // namespace tessera
