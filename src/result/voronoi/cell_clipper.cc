#include "src/result/voronoi/cell_clipper.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tessera::voronoi {

namespace {

namespace mp = boost::multiprecision;

int sign_of_turn(const Whole& ax, const Whole& ay, const Whole& bx, const Whole& by) {
  const Whole l = ax * by, r = ay * bx;
  return l < r ? -1 : (l > r ? 1 : 0);
}

// Whether all of the box is surely nearer to `other` than to `site`.
bool is_beyond(const Bounds& box, const Point& site, const Point& other) {
  long double sum = 0, size = 0;
  for (int axis = 0; axis < 2; ++axis) {
    const long double to = static_cast<long double>(other[axis]) - site[axis];
    const long double middle = (static_cast<long double>(other[axis]) + site[axis]) / 2;
    const long double at = to > 0 ? box.lo[axis] : box.hi[axis];
    sum += to * (at - middle);
    size += std::abs(to) * (std::abs(at) + std::abs(middle));
  }
  return sum > 0x1p-58L * size;
}

}  // namespace

CellClipper::Place CellClipper::place_of(const PlanarCell& cell) {
  near_.clear();
  Bounds box;
  if (cell.bounded) {
    for (const Point& corner : cell.corners) box.add(corner);
  } else {
    box = region_.bounds();
  }
  // Some of the neighbours tell enough.
  constexpr std::size_t looked_at = 24;
  const std::size_t step = (cell.around.size() + looked_at - 1) / looked_at;
  region_.visit(
      [&](const Bounds& of) {
        if (of.lo.x > box.hi.x || of.hi.x < box.lo.x || of.lo.y > box.hi.y || of.hi.y < box.lo.y) return false;
        for (std::size_t i = 0; i < cell.around.size(); i += step)
          if (is_beyond(of, cell.site, cell.around[i])) return false;
        return true;
      },
      [&](std::uint32_t edge) { near_.push_back(edge); });
  if (!near_.empty()) return Place::across;
  return region_.contains(cell.site) ? Place::inside : Place::outside;
}

CellShape CellClipper::shape(const PlanarCell& cell) {
  corners_.clear();
  segments_.clear();
  bisectors_.clear();
  arcs_.clear();
  std::sort(near_.begin(), near_.end());
  set_exponent(cell);
  make_cell(cell);
  cell_segments_ = segments_.size();
  make_edges();
  for (std::size_t c = 0; c < cell_segments_; ++c)
    for (std::size_t e = cell_segments_; e < segments_.size(); ++e) meet(c, e);
  for (std::size_t e = cell_segments_; e < segments_.size(); ++e) {
    for (const std::uint32_t other : region_.crossing(segments_[e].edge)) {
      const auto at = std::lower_bound(near_.begin(), near_.end(), other);
      if (at != near_.end() && *at == other && other > segments_[e].edge)
        meet(e, cell_segments_ + static_cast<std::size_t>(at - near_.begin()));
    }
  }
  const std::vector<Piece> all = pieces();
  for (std::size_t i = 0, end = 0; i < all.size(); i = end) {
    while (end < all.size() && all[end].low == all[i].low && all[end].high == all[i].high) ++end;
    keep(std::span(all).subspan(i, end - i));
  }
  return rounded_shape(trace());
}

void CellClipper::set_exponent(const PlanarCell& cell) {
  const auto take = [&](const Point& p) { exponent_ = std::min({exponent_, exponent_of(p.x), exponent_of(p.y)}); };
  exponent_ = region_.exponent();
  take(cell.site);
  for (const Point& p : cell.around) take(p);
  if (exponent_ == no_exponent) exponent_ = 0;
}

std::size_t CellClipper::add_corner(Whole x, Whole y, Whole w) {
  if (w < 0) {
    x = -x;
    y = -y;
    w = -w;
  }
  const Point at{rounded(x, w, exponent_), rounded(y, w, exponent_), 0};
  corners_.push_back({std::move(x), std::move(y), std::move(w), at});
  return corners_.size() - 1;
}

std::size_t CellClipper::add_point(const Point& p) {
  auto [x, y] = whole(p);
  corners_.push_back({std::move(x), std::move(y), 1, {p.x, p.y, 0}});
  return corners_.size() - 1;
}

int CellClipper::side(const Line& line, const Corner& corner) {
  return sign_of(line.a * corner.x + line.b * corner.y - line.c * corner.w);
}

// Rounding keeps the order, so different rounded numbers tell the order of the numbers.
bool CellClipper::less(const Corner& a, const Corner& b) {
  if (a.rounded.x != b.rounded.x) return a.rounded.x < b.rounded.x;
  const Whole ax = a.x * b.w, bx = b.x * a.w;
  if (ax != bx) return ax < bx;
  if (a.rounded.y != b.rounded.y) return a.rounded.y < b.rounded.y;
  return a.y * b.w < b.y * a.w;
}

// The cell's edges, counterclockwise: that of each point around the site is on the line of equal distances.
void CellClipper::make_cell(const PlanarCell& cell) {
  const auto [px, py] = whole(cell.site);
  const std::size_t n = cell.around.size();
  std::vector<std::array<Whole, 2>> to(n);  // from the site
  std::vector<Whole> square(n);
  for (std::size_t i = 0; i < n; ++i) {
    const auto [qx, qy] = whole(cell.around[i]);
    to[i] = {qx - px, qy - py};
    square[i] = to[i][0] * to[i][0] + to[i][1] * to[i][1];
    // 2 (q - p) x is less than q^2 - p^2 on the side of the site.
    bisectors_.push_back(
        {-2 * to[i][0], -2 * to[i][1], (px * px + py * py) - (qx * qx + qy * qy), -to[i][1], to[i][0]});
  }
  std::vector<std::size_t> centres;
  for (std::size_t i = 0; i + (cell.bounded ? 0 : 1) < n; ++i) {
    const auto& b = to[i];
    const auto& c = to[(i + 1) % n];
    const Whole &bb = square[i], &cc = square[(i + 1) % n];
    const Whole w = 2 * (b[0] * c[1] - b[1] * c[0]);
    centres.push_back(add_corner(px * w + bb * c[1] - cc * b[1], py * w + cc * b[0] - bb * c[0], w));
  }
  for (std::size_t i = 0; i < n; ++i) {
    const bool first = !cell.bounded && i == 0, last = !cell.bounded && i + 1 == n;
    std::size_t from = 0, end = 0;
    if (!first) from = centres[(i + centres.size() - 1) % centres.size()];
    if (!last) end = centres[i];
    if (first) from = far_corner(end, bisectors_[i], false);
    if (last) end = far_corner(from, bisectors_[i], true);
    segments_.push_back({.line = bisectors_[i], .of_cell = true, .from = from, .to = end});
  }
}

// A point on the line, ahead of a corner or behind it, beyond the region's box. The direction is at least as long as a
// unit, which is 2^exponent_.
std::size_t CellClipper::far_corner(std::size_t from, const Line& along, bool ahead) {
  const Corner corner = corners_[from];
  Whole reach = (mp::abs(corner.x) + mp::abs(corner.y)) / corner.w + 1;
  const Bounds& box = region_.bounds();
  for (const double side : {box.lo.x, box.lo.y, box.hi.x, box.hi.y}) reach += mp::abs(whole_of(side, exponent_));
  const Whole steps = (ahead ? 4 : -4) * reach * corner.w;
  return add_corner(corner.x + steps * along.dx, corner.y + steps * along.dy, corner.w);
}

void CellClipper::make_edges() {
  for (const std::uint32_t number : near_) {
    const ClipRegion::Edge& edge = region_.edges()[number];
    const auto [ax, ay] = whole(edge.a);
    const auto [bx, by] = whole(edge.b);
    const Whole dx = bx - ax, dy = by - ay;
    const std::size_t from = add_point(edge.a), to = add_point(edge.b);
    segments_.push_back({.line = {-dy, dx, dx * ay - dy * ax, dx, dy}, .edge = number, .from = from, .to = to});
  }
}

// Notes where two segments meet, on both.
void CellClipper::meet(std::size_t first, std::size_t second) {
  Segment &e = segments_[first], &f = segments_[second];
  const auto apart = [&](auto coordinate) {
    const double ea = coordinate(corners_[e.from].rounded), eb = coordinate(corners_[e.to].rounded);
    const double fa = coordinate(corners_[f.from].rounded), fb = coordinate(corners_[f.to].rounded);
    return std::max(ea, eb) < std::min(fa, fb) || std::max(fa, fb) < std::min(ea, eb);
  };
  if (apart([](const Point& p) { return p.x; }) || apart([](const Point& p) { return p.y; })) return;
  const int from_side = side(e.line, corners_[f.from]), to_side = side(e.line, corners_[f.to]);
  if (from_side * to_side > 0) return;
  const auto note = [&](Segment& on, std::size_t corner) {
    const Corner &a = corners_[on.from], &b = corners_[on.to], &c = corners_[corner];
    const bool up = less(a, b);
    if (less(up ? a : b, c) && less(c, up ? b : a)) on.on.push_back(corner);
  };
  if (from_side == 0 && to_side == 0) {
    note(e, f.from);
    note(e, f.to);
    note(f, e.from);
    note(f, e.to);
    return;
  }
  const int a_side = side(f.line, corners_[e.from]), b_side = side(f.line, corners_[e.to]);
  if (a_side * b_side > 0) return;
  if (from_side == 0) {
    note(e, f.from);
  } else if (to_side == 0) {
    note(e, f.to);
  } else if (a_side != 0 && b_side != 0) {
    const Line &l = e.line, &m = f.line;
    const std::size_t at = add_corner(l.c * m.b - m.c * l.b, l.a * m.c - m.a * l.c, l.a * m.b - m.a * l.b);
    e.on.push_back(at);
    f.on.push_back(at);
    return;
  }
  if (a_side == 0) note(f, e.from);
  if (b_side == 0) note(f, e.to);
}

// All segments cut at the corners on them, sorted.
std::vector<CellClipper::Piece> CellClipper::pieces() {
  std::vector<std::size_t> order(corners_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return less(corners_[a], corners_[b]); });
  rank_.assign(corners_.size(), 0);
  corner_of_.clear();
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i == 0 || less(corners_[order[i - 1]], corners_[order[i]])) corner_of_.push_back(order[i]);
    rank_[order[i]] = corner_of_.size() - 1;
  }
  std::vector<Piece> all;
  std::vector<std::size_t> ranks;
  for (std::size_t s = 0; s < segments_.size(); ++s) {
    Segment& segment = segments_[s];
    segment.reversed = rank_[segment.to] < rank_[segment.from];
    ranks = {rank_[segment.from], rank_[segment.to]};
    for (const std::size_t corner : segment.on) ranks.push_back(rank_[corner]);
    std::sort(ranks.begin(), ranks.end());
    ranks.erase(std::unique(ranks.begin(), ranks.end()), ranks.end());
    for (std::size_t i = 1; i < ranks.size(); ++i) all.push_back({ranks[i - 1], ranks[i], s});
  }
  std::sort(all.begin(), all.end(), [](const Piece& a, const Piece& b) {
    if (a.low != b.low) return a.low < b.low;
    return a.high != b.high ? a.high < b.high : a.segment < b.segment;
  });
  return all;
}

// Makes an arc of equal pieces when the shape is on one side of them.
void CellClipper::keep(std::span<const Piece> same) {
  const Segment& segment = segments_[same.front().segment];
  const Corner &a = corners_[corner_of_[same.front().low]], &b = corners_[corner_of_[same.front().high]];
  Corner middle{a.x * b.w + b.x * a.w, a.y * b.w + b.y * a.w, 2 * a.w * b.w, {}};
  middle.rounded = {rounded(middle.x, middle.w, exponent_), rounded(middle.y, middle.w, exponent_), 0};
  bool left = segment.of_cell ? !segment.reversed : in_cell(middle);
  bool right = segment.of_cell ? segment.reversed : left;
  if (!left && !right) return;
  const auto [region_left, region_right] = in_region(middle, same.front());
  left = left && region_left;
  right = right && region_right;
  if (left == right) return;
  const bool back = segment.reversed != right;  // the arc runs against the segment
  arcs_.push_back({.tail = left ? same.front().low : same.front().high,
                   .head = left ? same.front().high : same.front().low,
                   .dx = back ? Whole(-segment.line.dx) : segment.line.dx,
                   .dy = back ? Whole(-segment.line.dy) : segment.line.dy});
}

bool CellClipper::in_cell(const Corner& middle) const {
  return std::all_of(bisectors_.begin(), bisectors_.end(), [&](const Line& line) { return side(line, middle) > 0; });
}

// Whether the region is on the left and on the right of a piece, seen from its lower corner to its higher. A ray from
// the middle of the piece in the direction of x crosses edges of the region.
std::pair<bool, bool> CellClipper::in_region(const Corner& middle, const Piece& piece) const {
  const Segment& segment = segments_[piece.segment];
  const Point& near = middle.rounded;
  const int rise = sign_of(segment.line.dy) * (segment.reversed ? -1 : 1);
  std::vector<std::uint32_t> one, other;  // polygons whose edges are crossed from the side of x, and from the other
  const auto against = [&](double y, double rounded_y) {  // the sign of y - middle.y
    if (y != rounded_y) return y < rounded_y ? -1 : 1;
    const Whole l = whole_of(y, exponent_) * middle.w;
    return l < middle.y ? -1 : (l > middle.y ? 1 : 0);
  };
  region_.visit([&](const Bounds& box) { return box.lo.y <= near.y && near.y <= box.hi.y && near.x <= box.hi.x; },
                [&](std::uint32_t number) {
                  const ClipRegion::Edge& edge = region_.edges()[number];
                  const bool up = edge.a.y < edge.b.y;
                  const Point &low = up ? edge.a : edge.b, &high = up ? edge.b : edge.a;
                  const int below = against(low.y, near.y), above = against(high.y, near.y);
                  const bool from_above = below <= 0 && above > 0, from_below = below < 0 && above >= 0;
                  if (!from_above && !from_below) return;
                  int turn = 1;  // the middle is on the left of the edge, seen from its lower end
                  if (std::min(low.x, high.x) <= near.x) {
                    const auto [ax, ay] = whole(low);
                    const auto [bx, by] = whole(high);
                    const Whole dx = bx - ax, dy = by - ay;
                    turn = sign_of(dx * (middle.y - ay * middle.w) - dy * (middle.x - ax * middle.w));
                  }
                  if (rise == 0) {
                    if (from_above && turn > 0) one.push_back(edge.polygon);
                    if (from_below && turn > 0) other.push_back(edge.polygon);
                  } else if (from_above) {
                    if (turn > 0) one.push_back(edge.polygon);
                    if (turn >= 0) other.push_back(edge.polygon);
                  }
                });
  const bool first = has_odd(one), second = has_odd(other);
  // `one` is above a level piece, and else on the side of greater x.
  return rise < 0 || rise == 0 ? std::pair(first, second) : std::pair(second, first);
}

// The next arc of a ring: the first one clockwise from the way back. Both bound the same wedge of the shape.
std::size_t CellClipper::next_arc(std::size_t arc, std::span<const std::size_t> out) const {
  const Whole back_x = -arcs_[arc].dx, back_y = -arcs_[arc].dy;
  // Halves of the turn clockwise from the way back: 0 is less than half a turn, 1 is half or more.
  const auto half = [&](const Arc& a) {
    const int turn = sign_of_turn(back_x, back_y, a.dx, a.dy);
    return turn < 0 ? 0 : 1;
  };
  std::size_t best = out.front();
  for (const std::size_t candidate : out.subspan(1)) {
    const Arc &a = arcs_[candidate], &b = arcs_[best];
    const int half_a = half(a), half_b = half(b);
    if (half_a != half_b ? half_a < half_b : sign_of_turn(a.dx, a.dy, b.dx, b.dy) < 0) best = candidate;
  }
  return best;
}

// Rings of corners' ranks, each without a repeated corner.
std::vector<std::vector<std::size_t>> CellClipper::trace() {
  std::vector<std::size_t> by_tail(arcs_.size());
  std::iota(by_tail.begin(), by_tail.end(), std::size_t{0});
  const auto tail = [&](std::size_t arc) { return arcs_[arc].tail; };
  std::sort(by_tail.begin(), by_tail.end(), [&](std::size_t a, std::size_t b) {
    return tail(a) != tail(b) ? tail(a) < tail(b) : arcs_[a].head < arcs_[b].head;
  });
  const auto out_of = [&](std::size_t corner) {
    const auto first = std::lower_bound(by_tail.begin(), by_tail.end(), corner,
                                        [&](std::size_t arc, std::size_t c) { return tail(arc) < c; });
    auto end = first;
    while (end != by_tail.end() && tail(*end) == corner) ++end;
    return std::span<const std::size_t>(first, end);
  };
  std::vector<std::vector<std::size_t>> rings;
  std::vector<std::size_t> place(corner_of_.size(), 0);  // one more than the place in the open ring
  for (const std::size_t begin : by_tail) {
    std::vector<std::size_t> open;
    for (std::size_t arc = begin; !arcs_[arc].used; arc = next_arc(arc, out_of(arcs_[arc].head))) {
      arcs_[arc].used = true;
      const std::size_t corner = arcs_[arc].tail;
      if (place[corner] > 0) {  // the ring closes here, and a ring that came this way goes on
        const std::size_t at = place[corner] - 1;
        rings.emplace_back(open.begin() + static_cast<std::ptrdiff_t>(at), open.end());
        for (std::size_t i = at; i < open.size(); ++i) place[open[i]] = 0;
        open.resize(at);
      }
      open.push_back(corner);
      place[corner] = open.size();
    }
    for (const std::size_t corner : open) place[corner] = 0;
    if (open.size() > 2) rings.push_back(std::move(open));
  }
  return rings;
}

namespace {

// Whether the ring goes around a point that is none of its corners and on none of its sides.
bool goes_around(const Ring& ring, const Point& p) {
  bool inside = false;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Point &a = ring[i], &b = ring[(i + 1) % ring.size()];
    const bool up = a.y < b.y;
    const Point &low = up ? a : b, &high = up ? b : a;
    if (!(low.y <= p.y && p.y < high.y)) continue;
    const long double turn = (static_cast<long double>(high.x) - low.x) * (static_cast<long double>(p.y) - low.y) -
                             (static_cast<long double>(high.y) - low.y) * (static_cast<long double>(p.x) - low.x);
    if (turn > 0) inside = !inside;
  }
  return inside;
}

// The outer ring of a hole: the one around a corner of the hole, or around the middle of a side.
std::size_t owner_of(const Ring& hole, const std::vector<std::vector<Ring>>& parts) {
  for (std::size_t i = 0; i < hole.size(); ++i) {
    const Point &a = hole[i], &b = hole[(i + 1) % hole.size()];
    const Point middle{a.x / 2 + b.x / 2, a.y / 2 + b.y / 2, 0};
    for (std::size_t p = 0; p < parts.size(); ++p)
      if (goes_around(parts[p].front(), middle)) return p;
  }
  return 0;
}

}  // namespace

CellShape CellClipper::rounded_shape(const std::vector<std::vector<std::size_t>>& rings) const {
  CellShape shape;
  std::vector<Ring> holes;
  for (const auto& ring : rings) {
    const std::size_t n = ring.size();
    const auto least = static_cast<std::size_t>(std::min_element(ring.begin(), ring.end()) - ring.begin());
    const auto at = [&](std::size_t i) -> const Corner& { return corners_[corner_of_[ring[i % n]]]; };
    const Corner &a = at(least + n - 1), &b = at(least), &c = at(least + 1);
    const int turn =
        sign_of_turn(b.x * a.w - a.x * b.w, b.y * a.w - a.y * b.w, c.x * b.w - b.x * c.w, c.y * b.w - b.y * c.w);
    Ring rounded_ring;
    for (std::size_t i = 0; i < n; ++i) rounded_ring.push_back(at(i).rounded);
    remove_repeated(rounded_ring);
    if (rounded_ring.size() < 3 && turn < 0) continue;  // a hole that is thinner than doubles resolve
    if (!rounded_ring.empty()) begin_with_least(rounded_ring);
    if (turn > 0) {
      shape.parts.push_back({std::move(rounded_ring)});
    } else {
      holes.push_back(std::move(rounded_ring));
    }
  }
  for (Ring& hole : holes) {
    if (shape.parts.empty()) break;
    const std::size_t part = shape.parts.size() == 1 ? 0 : owner_of(hole, shape.parts);
    shape.parts[part].push_back(std::move(hole));
  }
  return shape;
}

}  // namespace tessera::voronoi
