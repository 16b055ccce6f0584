#include "src/run/mail.h"

#include <string>
#include <utility>

#include "src/run/update_bytes.h"

namespace tessera {

Status Mail::add(Update update, TileStorage& storage) {
  ++updates_;
  points_ += update.points.size();
  held_points_ += update.points.size();
  held_.push_back(std::move(update));
  return held_points_ > points_max_ ? spill(storage) : success();
}

Status Mail::spill(TileStorage& storage) {
  FlatWriter out;
  out.reserve(held_points_ * sizeof(SharedPoint) + held_.size() * 40);
  for (const Update& update : held_) put(out, update);
  std::vector<Update>().swap(held_);
  held_points_ = 0;
  return storage.append(tile_, ScratchKind::mail, out.take());
}

Status Mail::clear(TileStorage& storage) {
  const bool spilled = held_.size() < updates_;
  std::vector<Update>().swap(held_);
  held_points_ = updates_ = points_ = 0;
  return spilled ? storage.remove(tile_, ScratchKind::mail) : success();
}

Result<std::vector<Update>> Mail::take(TileStorage& storage) {
  std::vector<Update> all;
  if (held_.size() < updates_) {
    BOOST_OUTCOME_TRY(pieces, storage.read(tile_, ScratchKind::mail));
    all.reserve(updates_);
    std::uint64_t points = held_points_;
    for (auto& piece : pieces) {
      FlatReader in(piece);
      while (!in.at_end()) {
        Update update;
        if (!get(in, update)) break;
        points += update.points.size();
        all.push_back(std::move(update));
      }
      BigVector<std::byte>().swap(piece);
    }
    if (points != points_ || all.size() + held_.size() != updates_) {
      return error(Errc::corrupt,
                   "tile " + std::to_string(tile_.value) + ": its mail on disk is not what was put there");
    }
    BOOST_OUTCOME_TRYV(storage.remove(tile_, ScratchKind::mail));
  }
  for (Update& update : held_) all.push_back(std::move(update));
  std::vector<Update>().swap(held_);
  held_points_ = updates_ = points_ = 0;
  return all;
}

}  // namespace tessera
