#include "src/tiling/tile/fresh_points.h"

#include <algorithm>

namespace tessera {

FreshPoints::FreshPoints(std::span<const std::uint8_t> own) {
  fresh_.reserve(own.size() + 1);
  fresh_.push_back(0);  // the infinite vertex
  for (const std::uint8_t fresh : own) {
    if (fresh != 0) due_.push_back(static_cast<Vertex>(fresh_.size()));
    fresh_.push_back(fresh);
  }
}

void FreshPoints::learn_all() {
  std::fill(fresh_.begin(), fresh_.end(), std::uint8_t{1});
  due_.clear();
}

void FreshPoints::replay(const std::function<bool(TileId)>& reborn,
                         const std::function<void(Vertex, TileId)>& tell) const {
  for (const std::uint64_t pair : quoted_) {
    const TileId tile{static_cast<std::uint32_t>(pair)};
    if (reborn(tile)) tell(static_cast<Vertex>(pair >> 32), tile);
  }
}

FreshPoints::State FreshPoints::state() const {
  return {fresh_, due_, {quoted_.begin(), quoted_.end()}, {refused_.begin(), refused_.end()}};
}

bool FreshPoints::State::fits(std::size_t vertices) const {
  return fresh.size() == vertices && std::all_of(due.begin(), due.end(), [&](Vertex v) { return v < vertices; }) &&
         std::all_of(quoted.begin(), quoted.end(), [&](std::uint64_t pair) { return pair >> 32 < vertices; });
}

FreshPoints::FreshPoints(State state)
    : fresh_(std::move(state.fresh)),
      due_(std::move(state.due)),
      quoted_(state.quoted.begin(), state.quoted.end()),
      refused_(state.refused.begin(), state.refused.end()) {}

}  // namespace tessera
