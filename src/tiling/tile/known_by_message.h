// What other tiles know of the vertices of one tile, because messages have told them: the sent-set, the told bits, and
// what this tile relied on (docs/glossary.md). What they know without messages is in known_from_start.h. Most functions
// are inline: a tile asks for every two neighbours among its new vertices.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "src/base/ids.h"
#include "src/base/point.h"
#include "src/geometry/kernel/kernel.h"
#include "src/tiling/tile/known_from_start.h"
#include "src/tiling/tile/sent_set.h"

namespace tessera {

// A vertex is given with its owner, who tells which bit stands for which tile. Not thread-safe.
class KnownByMessage {
 public:
  // `around` must outlive this object.
  explicit KnownByMessage(const KnownFromStart* around) : around_(around) {}

  // Sets the number of vertices, the infinite vertex included. The told bits of all of them become 0.
  void set_vertices(std::size_t vertices) { told_.assign(vertices, 0); }
  // Appends a vertex. `told`: the bits that came with it.
  void add_vertex(std::uint32_t told) { told_.push_back(told); }
  // SharedPoint::told of a vertex.
  std::uint32_t told(Vertex v) const { return told_[v]; }

  // Whether this tile has sent v to `tile`, or has received v from it, or has relied on somebody who has sent it.
  bool has(Vertex v, TileId tile) const { return sent_.has(v, tile); }
  // Notes that `tile` knows v.
  void record_sent(Vertex v, TileId owner, TileId tile) {
    if (sent_.add(v, tile)) told_[v] |= around_->bit(owner, tile);
  }
  // Notes what a message says of a vertex: the sender knows it, and the told bits.
  void record_received(Vertex v, TileId owner, TileId from, std::uint32_t told) {
    record_sent(v, owner, from);
    told_[v] |= told;
  }
  // Notes the told bits alone, of a message that does not say that its sender knows the vertex.
  void record_quoted(Vertex v, std::uint32_t told) { told_[v] |= told; }
  // The same without told bits, which the published rule does not have.
  void record_published(Vertex v, TileId from) { sent_.add(v, from); }

  // Whether some tile has told `tile` of v. From now on the pair counts as sent by this tile, too, so that it is sent
  // again after a restart or a loss.
  bool rely_on_told_bit(Vertex v, TileId owner, TileId tile) {
    if (told_[v] == 0 || (told_[v] & around_->bit(owner, tile)) == 0) return false;
    if (sent_.add(v, tile)) relied_.push_back(std::uint64_t{v} << 32 | tile.value);
    return true;
  }
  // Whether `tile` has been told of a refused point that came from `from`. That point is no vertex, so it cannot be in
  // the sent-set.
  bool rely_on_told_bit_of_refused(const SharedPoint& point, TileId from, TileId tile);

  // Renames vertex v to to[v], as SentSet::renumber(). The told bits become 0.
  void renumber(const std::vector<Vertex>& to, std::size_t vertices) {
    sent_.renumber(to);
    set_vertices(vertices);
  }
  // Forgets the told bits that other tiles have sent. `owners`: by vertex.
  void forget_told_bits(std::span<const TileId> owners);
  // Calls `tell` and `tell_refused` for what must be sent again. `reborn`: whether a tile has lost what it knew. Those
  // tiles are told again of all that they knew. The others are told of what this tile has relied on: the tile that
  // claimed to have told them may have died before its message arrived. From now on all of this counts as sent by this
  // tile, and so do the told bits that are left.
  void replay(std::span<const TileId> owners, const std::function<bool(TileId)>& reborn,
              const std::function<void(Vertex, TileId)>& tell,
              const std::function<void(const SharedPoint&, TileId)>& tell_refused);

  // For the image of a tile.
  struct RefusedRelied {
    SharedPoint point;
    TileId tile;  // has heard of the point
    // 1: a told bit said so; 0: the tile has sent the point itself, or this tile has sent it
    std::uint32_t by_told_bit = 0;
  };
  struct State {
    std::vector<std::uint32_t> told;
    std::vector<std::uint64_t> sent, relied;  // vertex << 32 | tile
    std::vector<RefusedRelied> refused_relied;
  };
  const std::vector<std::uint32_t>& told_bits() const { return told_; }
  std::vector<std::uint64_t> sent() const { return sent_.keys(); }
  const std::vector<std::uint64_t>& relied() const { return relied_; }
  const std::vector<RefusedRelied>& refused_relied() const { return refused_relied_; }
  // REQUIRES: the vertices of all pairs are below told.size().
  void restore(State state);

  std::size_t memory() const {
    return told_.capacity() * 4 + sent_.memory() + relied_.capacity() * 8 +
           refused_relied_.capacity() * sizeof(RefusedRelied);
  }

 private:
  const KnownFromStart* around_;
  SentSet sent_;
  std::vector<std::uint32_t> told_;  // by vertex: SharedPoint::told
  // What this tile did not send because others had sent it: pairs vertex << 32 | tile, which are in the sent-set as
  // well, and the same of refused points. All of this life of the tile.
  std::vector<std::uint64_t> relied_;
  std::vector<RefusedRelied> refused_relied_;
};

}  // namespace tessera
