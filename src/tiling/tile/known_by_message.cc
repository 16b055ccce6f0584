#include "src/tiling/tile/known_by_message.h"

#include <algorithm>

namespace tessera {
namespace {

Vertex vertex_of(std::uint64_t pair) { return static_cast<Vertex>(pair >> 32); }
TileId tile_of(std::uint64_t pair) { return TileId{static_cast<std::uint32_t>(pair)}; }

}  // namespace

bool KnownByMessage::rely_on_told_bit_of_refused(const SharedPoint& point, TileId from, TileId tile) {
  const bool itself = tile == from;
  if (!itself && (point.told & around_->bit(point.tile, tile)) == 0) return false;
  for (auto r = refused_relied_.rbegin(); r != refused_relied_.rend() && r->point.id == point.id; ++r) {
    if (r->tile == tile) return true;  // noted before, for another neighbour
  }
  refused_relied_.push_back({{point.at, point.id, point.tile, 0}, tile, itself ? 0u : 1u});
  return true;
}

void KnownByMessage::forget_told_bits(std::span<const TileId> owners) {
  std::fill(told_.begin(), told_.end(), 0);
  for (const std::uint64_t pair : sent_.keys()) {
    const Vertex v = vertex_of(pair);
    told_[v] |= around_->bit(owners[v], tile_of(pair));
  }
}

void KnownByMessage::replay(std::span<const TileId> owners, const std::function<bool(TileId)>& reborn,
                            const std::function<void(Vertex, TileId)>& tell,
                            const std::function<void(const SharedPoint&, TileId)>& tell_refused) {
  for (const std::uint64_t pair : sent_.keys()) {
    const TileId tile = tile_of(pair);
    if (owners[vertex_of(pair)] != tile && reborn(tile)) tell(vertex_of(pair), tile);
  }
  for (const std::uint64_t pair : relied_) {
    if (!reborn(tile_of(pair))) tell(vertex_of(pair), tile_of(pair));
  }
  relied_.clear();
  for (RefusedRelied& r : refused_relied_) {
    if (!r.by_told_bit && !reborn(r.tile)) continue;
    tell_refused(r.point, r.tile);
    r.by_told_bit = 0;
  }
  forget_told_bits(owners);
}

void KnownByMessage::restore(State state) {
  told_ = std::move(state.told);
  sent_ = {};
  for (const std::uint64_t pair : state.sent) sent_.add(vertex_of(pair), tile_of(pair));
  relied_ = std::move(state.relied);
  refused_relied_ = std::move(state.refused_relied);
}

}  // namespace tessera
