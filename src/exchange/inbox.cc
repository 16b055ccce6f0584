#include "src/exchange/inbox.h"

#include <string>
#include <utility>

#include "src/exchange/update_bytes.h"

namespace tessera {

Status Inbox::add(Update update, TileStorage& storage) {
  ++updates_;
  bytes_ += update.message.size();
  held_bytes_ += update.message.size();
  held_.push_back(std::move(update));
  return held_bytes_ > bytes_max_ ? spill(storage) : success();
}

Status Inbox::spill(TileStorage& storage) {
  FlatWriter out;
  out.reserve(held_bytes_ + held_.size() * 40);
  for (const Update& update : held_) put(out, update);
  std::vector<Update>().swap(held_);
  held_bytes_ = 0;
  return storage.append(tile_, ScratchKind::mail, out.take());
}

Status Inbox::clear(TileStorage& storage) {
  const bool spilled = held_.size() < updates_;
  std::vector<Update>().swap(held_);
  held_bytes_ = updates_ = bytes_ = 0;
  return spilled ? storage.remove(tile_, ScratchKind::mail) : success();
}

Result<std::vector<Update>> Inbox::take(TileStorage& storage) {
  std::vector<Update> all;
  if (held_.size() < updates_) {
    BOOST_OUTCOME_TRY(pieces, storage.read(tile_, ScratchKind::mail));
    all.reserve(updates_);
    std::uint64_t bytes = held_bytes_;
    for (auto& piece : pieces) {
      FlatReader in(piece);
      while (!in.at_end()) {
        Update update;
        if (!get(in, update)) break;
        bytes += update.message.size();
        all.push_back(std::move(update));
      }
      BigVector<std::byte>().swap(piece);
    }
    if (bytes != bytes_ || all.size() + held_.size() != updates_) {
      return error(Errc::corrupt,
                   "tile " + std::to_string(tile_.value) + ": the updates that wait for it on disk are damaged");
    }
    BOOST_OUTCOME_TRYV(storage.remove(tile_, ScratchKind::mail));
  }
  for (Update& update : held_) all.push_back(std::move(update));
  std::vector<Update>().swap(held_);
  held_bytes_ = updates_ = bytes_ = 0;
  return all;
}

}  // namespace tessera
