// Converts updates to bytes and back, for scratch.
#pragma once

#include "src/base/flat_codec.h"
#include "src/exchange/update.h"

namespace tessera {

inline void put(FlatWriter& out, const Update& update) {
  out.value(update.from);
  out.value(update.to);
  out.value(update.epoch);
  out.value(update.hops);
  out.list(update.message);
}

// Returns false when the bytes are not those of an update.
inline bool get(FlatReader& in, Update& update) {
  return in.value(update.from) && in.value(update.to) && in.value(update.epoch) && in.value(update.hops) &&
         in.list(update.message);
}

}  // namespace tessera
