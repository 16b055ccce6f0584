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

bool FreshPoints::add_refused_quote(const SharedPoint& p, TileId tile) {
  for (auto q = refused_quotes_.rbegin(); q != refused_quotes_.rend() && q->point.id == p.id; ++q) {
    if (q->tile == tile) return false;  // for another neighbour
  }
  refused_quotes_.push_back({{p.at, p.id, p.tile, 0}, tile});
  return true;
}

void FreshPoints::replay(const std::function<bool(TileId)>& reborn, const std::function<void(Vertex, TileId)>& tell,
                         const std::function<void(const SharedPoint&, TileId)>& tell_refused) const {
  for (const std::uint64_t pair : quoted_) {
    const TileId tile{static_cast<std::uint32_t>(pair)};
    if (reborn(tile)) tell(static_cast<Vertex>(pair >> 32), tile);
  }
  for (const RefusedQuote& q : refused_quotes_) {
    if (reborn(q.tile)) tell_refused(q.point, q.tile);
  }
}

FreshPoints::State FreshPoints::state() const {
  return {fresh_, due_, {quoted_.begin(), quoted_.end()}, {refused_.begin(), refused_.end()}, refused_quotes_};
}

bool FreshPoints::State::fits(std::size_t vertices) const {
  return fresh.size() == vertices && std::all_of(due.begin(), due.end(), [&](Vertex v) { return v < vertices; }) &&
         std::all_of(quoted.begin(), quoted.end(), [&](std::uint64_t pair) { return pair >> 32 < vertices; });
}

FreshPoints::FreshPoints(State state)
    : fresh_(std::move(state.fresh)),
      due_(std::move(state.due)),
      quoted_(state.quoted.begin(), state.quoted.end()),
      refused_(state.refused.begin(), state.refused.end()),
      refused_quotes_(std::move(state.refused_quotes)) {}

}  // namespace tessera
