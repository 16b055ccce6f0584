#include "src/result/alpha/tile_outline.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "src/base/disjoint_sets.h"

namespace tessera::alpha {

namespace {

constexpr std::uint32_t no_piece = std::numeric_limits<std::uint32_t>::max();

class Tracer {
 public:
  Tracer(const TileMesh& mesh, const std::vector<std::uint8_t>& in)
      : mesh_(mesh), in_(in), seen_(in.size() * 3, 0), pieces_(in.size(), no_piece) {}

  std::optional<TileOutline> trace() {
    number_pieces();
    // First the chains that come from other tiles, so that what is left is closed.
    for (const bool from_outside : {true, false}) {
      for (std::size_t edge = 0; edge < seen_.size(); ++edge) {
        if (seen_[edge] != 0 || !is_boundary(edge) || !own(to(edge)) || own(from(edge)) == from_outside) continue;
        if (!follow(edge)) return std::nullopt;
      }
    }
    return std::move(outline_);
  }

 private:
  // An edge is 3 times a cell, plus the corner that it is opposite.
  std::int32_t from(std::size_t edge) const { return mesh_.cells[edge - edge % 3 + (edge % 3 + 1) % 3]; }
  std::int32_t to(std::size_t edge) const { return mesh_.cells[edge - edge % 3 + (edge % 3 + 2) % 3]; }
  bool own(std::int32_t v) const { return mesh_.point_ghost[static_cast<std::size_t>(v)] == 0; }
  PointId id(std::int32_t v) const { return mesh_.ids[static_cast<std::size_t>(v)]; }
  bool is_boundary(std::size_t edge) const {
    if (in_[edge / 3] == 0) return false;
    const std::int32_t neighbor = mesh_.neighbors[edge];
    return neighbor < 0 || in_[static_cast<std::size_t>(neighbor)] == 0;
  }

  // The boundary edge that follows at an own vertex: turns around the vertex through cells in the shape.
  std::optional<std::size_t> next(std::size_t edge) const {
    const std::int32_t at = to(edge);
    // The edge of the same cell that leaves `at` is opposite the corner where `edge` begins.
    std::size_t leaving = edge - edge % 3 + (edge % 3 + 1) % 3;
    for (std::size_t turned = 0; !is_boundary(leaving); ++turned) {
      const auto cell = static_cast<std::size_t>(mesh_.neighbors[leaving]);
      std::size_t k = 0;
      while (k < 3 && mesh_.cells[3 * cell + k] != at) ++k;
      if (k == 3 || turned == in_.size()) return std::nullopt;
      leaving = 3 * cell + (k + 2) % 3;  // from corner k to the next corner
    }
    return leaving;
  }

  // Returns false when neighbours contradict each other.
  bool follow(std::size_t first) {
    OutlineChain chain;
    chain.begin = outline_.vertices.size();
    chain.piece = pieces_[first / 3];
    chain.closed = own(from(first));
    chain.first = {id(from(first)), id(to(first))};
    std::size_t edge = first;
    do {
      if (seen_[edge] != 0) return false;
      seen_[edge] = 1;
      if (!own(to(edge))) break;
      const Point& p = mesh_.points[static_cast<std::size_t>(to(edge))];
      outline_.vertices.push_back({id(to(edge)), p.x, p.y});
      const auto following = next(edge);
      if (!following) return false;
      edge = *following;
    } while (edge != first);
    chain.last = {id(from(edge)), id(to(edge))};
    chain.end = outline_.vertices.size();
    outline_.chains.push_back(chain);
    return true;
  }

  void number_pieces() {
    DisjointSets sets(in_.size());
    for (std::size_t edge = 0; edge < seen_.size(); ++edge) {
      const std::int32_t neighbor = mesh_.neighbors[edge];
      if (neighbor < 0 || in_[edge / 3] == 0 || in_[static_cast<std::size_t>(neighbor)] == 0) continue;
      sets.join(sets.find(static_cast<std::uint32_t>(edge / 3)), sets.find(static_cast<std::uint32_t>(neighbor)));
    }
    std::vector<std::uint32_t> numbers(in_.size(), no_piece);
    for (std::size_t cell = 0; cell < in_.size(); ++cell) {
      if (in_[cell] == 0) continue;
      std::uint32_t& number = numbers[sets.find(static_cast<std::uint32_t>(cell))];
      if (number == no_piece) number = outline_.pieces++;
      pieces_[cell] = number;
      const std::array<std::int32_t, 3> at{mesh_.cells[3 * cell], mesh_.cells[3 * cell + 1], mesh_.cells[3 * cell + 2]};
      if (own(at[0]) && own(at[1]) && own(at[2])) continue;
      SharedCell shared{{id(at[0]), id(at[1]), id(at[2])}, number};
      std::sort(shared.ids.begin(), shared.ids.end());
      outline_.shared.push_back(shared);
    }
  }

  const TileMesh& mesh_;
  const std::vector<std::uint8_t>& in_;
  std::vector<std::uint8_t> seen_;     // by edge
  std::vector<std::uint32_t> pieces_;  // by cell
  TileOutline outline_;
};

}  // namespace

std::optional<TileOutline> outline_of(const TileMesh& mesh, const std::vector<std::uint8_t>& in) {
  return Tracer(mesh, in).trace();
}

}  // namespace tessera::alpha
