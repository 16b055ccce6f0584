#include "src/run/mail.h"

#include <string>
#include <utility>

#include "src/base/flat_codec.h"

namespace tessera {

Status Mail::add(Batch batch, TileStorage& storage) {
  ++batches_;
  points_ += batch.points.size();
  held_points_ += batch.points.size();
  held_.push_back(std::move(batch));
  return held_points_ > points_max_ ? spill(storage) : success();
}

Status Mail::spill(TileStorage& storage) {
  FlatWriter out;
  out.reserve(held_points_ * sizeof(SharedPoint) + held_.size() * 32);
  for (const Batch& batch : held_) {
    out.value(batch.from);
    out.value(batch.to);
    out.value(batch.hops);
    out.list(batch.points);
  }
  std::vector<Batch>().swap(held_);
  held_points_ = 0;
  return storage.append(tile_, ScratchKind::mail, out.take());
}

Result<std::vector<Batch>> Mail::take(TileStorage& storage) {
  std::vector<Batch> all;
  if (held_.size() < batches_) {
    BOOST_OUTCOME_TRY(pieces, storage.read(tile_, ScratchKind::mail));
    all.reserve(batches_);
    std::uint64_t points = held_points_;
    for (auto& piece : pieces) {
      FlatReader in(piece);
      while (!in.at_end()) {
        Batch batch;
        if (!in.value(batch.from) || !in.value(batch.to) || !in.value(batch.hops) || !in.list(batch.points)) break;
        points += batch.points.size();
        all.push_back(std::move(batch));
      }
      std::vector<std::byte>().swap(piece);
    }
    if (points != points_ || all.size() + held_.size() != batches_) {
      return error(Errc::corrupt,
                   "tile " + std::to_string(tile_.value) + ": its mail on disk is not what was put there");
    }
    BOOST_OUTCOME_TRYV(storage.remove(tile_, ScratchKind::mail));
  }
  for (Batch& batch : held_) all.push_back(std::move(batch));
  std::vector<Batch>().swap(held_);
  held_points_ = batches_ = points_ = 0;
  return all;
}

}  // namespace tessera
