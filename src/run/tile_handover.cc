// A tile that goes from one node to another in order: docs/cluster.md, "Draining".
//
// What is handed over is one piece: the image, the tile's list of final cells if it has one, the bytes of the image.
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>

#include "src/base/check.h"
#include "src/run/tile_state.h"

namespace tessera {

Status TileState::hand_over() {
  check(phase_ == Phase::awake || phase_ == Phase::asleep, "only a tile that has begun is handed over");
  const Status written = write_handed();
  drop();
  handed_ = true;
  call_ = false;
  BOOST_OUTCOME_TRYV(mail_.clear(*context_.storage));
  return written;
}

Status TileState::write_handed() {
  if (finals_) {
    BOOST_OUTCOME_TRYV(put_finals());
  }
  BOOST_OUTCOME_TRY(bytes, image());
  const std::uint64_t of_image = bytes.size();
  BOOST_OUTCOME_TRY(finals, context_.storage->read(self_.tile, ScratchKind::finals));
  if (finals.size() > 1) return damaged("list of final cells");
  if (!finals.empty()) bytes.insert(bytes.end(), finals[0].begin(), finals[0].end());
  const auto length = std::as_bytes(std::span(&of_image, 1));
  bytes.insert(bytes.end(), length.begin(), length.end());
  return context_.storage->hand_over(self_.tile, bytes);
}

// Whose it was, and how old it is, does not matter: an image is a right beginning whatever the others have done since.
// If it cannot be read, the tile's points are one, too.
Result<bool> TileState::restore_handed() {
  auto pieces = context_.storage->handed(self_.tile);
  std::uint64_t of_image = 0;
  if (!pieces || pieces.value().size() != 1 || pieces.value()[0].size() < sizeof of_image) return false;
  BigVector<std::byte> bytes = std::move(pieces.value()[0]);
  const std::size_t end = bytes.size() - sizeof of_image;
  std::memcpy(&of_image, bytes.data() + end, sizeof of_image);
  if (of_image > end) return false;
  const BigVector<std::byte> finals(bytes.begin() + static_cast<std::ptrdiff_t>(of_image),
                                    bytes.begin() + static_cast<std::ptrdiff_t>(end));
  bytes.resize(of_image);
  ImageEnd parts;
  auto tile = load_image(std::move(bytes), parts);
  if (!tile) return false;
  own_points_ = parts.own_points;
  finals_sum_ = parts.finals_sum;
  if (tile->handed_out()) {
    BOOST_OUTCOME_TRY(sound, restore_finals(finals, false));
    if (!sound) return false;
  }
  triangulation_ = std::move(tile);
  BOOST_OUTCOME_TRYV(go_on_from_image());
  return true;
}

}  // namespace tessera
