#include "src/delaunay/heard_points.h"

#include <algorithm>
#include <cstring>
#include <span>
#include <string>

#include "src/exchange/update.h"
#include "src/geometry/kernel/brio.h"
#include "src/tiling/hilbert.h"

namespace tessera {

Status HeardPoints::add(TileId self, TileId from, const Message& message, std::uint32_t believed) {
  if (message.size() % sizeof(SharedPoint) != 0) {
    return error(Errc::internal, "tile " + std::to_string(self.value) + ": tile " + std::to_string(from.value) +
                                     " has sent " + std::to_string(message.size()) +
                                     " bytes, which is not a whole number of points");
  }
  for (std::size_t at = 0; at < message.size(); at += sizeof(SharedPoint)) {
    Heard& heard = heard_.emplace_back();
    heard.from = from;
    std::memcpy(&heard.point, message.data() + at, sizeof(SharedPoint));
    heard.point.told &= believed;
  }
  return success();
}

// Inserts points in Hilbert order, so that each insertion starts where the last one ended, but a few random points
// first. The first points beyond the hull see a whole face of it, and in Hilbert order alone every point would be the
// first of its region. The random points are few, because they are far from each other, and the cells of each must be
// fetched into the cache.
Status HeardPoints::insert_into(TileTriangulation& triangulation, int dimension) {
  struct Item {
    std::uint64_t key;
    const Heard* heard;
  };
  const std::vector<Heard> heard = std::exchange(heard_, {});
  Bounds bounds;
  for (const Heard& h : heard) bounds.add(h.point.at);
  const HilbertKey key(bounds, dimension);
  std::vector<Item> items;
  items.reserve(heard.size());
  for (const Heard& h : heard) items.push_back({key(h.point.at), &h});
  std::stable_sort(items.begin(), items.end(), [](const Item& a, const Item& b) { return a.key < b.key; });
  Status done = success();
  for_each_in_brio_order<5>(items.size(), [&](std::size_t i) {
    if (done) done = triangulation.receive(items[i].heard->from, std::span(&items[i].heard->point, 1));
  });
  return done;
}

std::vector<std::pair<TileId, Message>> messages_of(TileTriangulation& triangulation) {
  constexpr std::size_t most = message_bytes_max / sizeof(SharedPoint);
  std::vector<std::pair<TileId, Message>> out;
  for (const auto& [tile, points] : triangulation.take_updates()) {
    std::span<const SharedPoint> rest(points);
    for (; !rest.empty(); rest = rest.subspan(std::min(most, rest.size()))) {
      const auto bytes = std::as_bytes(rest.first(std::min(most, rest.size())));
      out.emplace_back(tile, Message(bytes.begin(), bytes.end()));
    }
  }
  return out;
}

}  // namespace tessera
