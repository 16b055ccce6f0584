#include "src/result/voronoi/box_clipper.h"

#include <algorithm>

namespace tessera::voronoi {

namespace {

Whole determinant(const std::array<Whole, 3>& a, const std::array<Whole, 3>& b, const std::array<Whole, 3>& c) {
  return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
}

constexpr std::size_t box_planes = 6;

}  // namespace

bool BoxClipper::clip(const Point& site, std::span<const Point> around, PolyhedronMaker& maker) {
  begin(site, around);
  for (std::size_t plane = box_planes; plane < planes_.size(); ++plane)
    if (!cut(plane)) return false;
  std::sort(faces_.begin(), faces_.end(), [](const Face& a, const Face& b) {
    const bool a_box = a.plane < box_planes, b_box = b.plane < box_planes;
    return a_box != b_box ? b_box : a.plane < b.plane;
  });
  std::vector<Point> ring;
  for (const Face& face : faces_) {
    ring.clear();
    for (const std::size_t number : face.ring) {
      const Corner& c = corners_[number];
      ring.push_back({rounded(c.x, c.w, exponent_), rounded(c.y, c.w, exponent_), rounded(c.z, c.w, exponent_)});
    }
    maker.add_face(ring);
  }
  return true;
}

// Makes the planes, and the box as a polyhedron.
void BoxClipper::begin(const Point& site, std::span<const Point> around) {
  exponent_ = no_exponent;
  const auto take = [&](const Point& p) {
    for (int axis = 0; axis < 3; ++axis) exponent_ = std::min(exponent_, exponent_of(p[axis]));
  };
  take(box_.lo);
  take(box_.hi);
  take(site);
  for (const Point& p : around) take(p);
  const auto whole = [&](const Point& p) -> std::array<Whole, 3> {
    return {whole_of(p.x, exponent_), whole_of(p.y, exponent_), whole_of(p.z, exponent_)};
  };
  planes_.clear();
  corners_.clear();
  faces_.clear();
  const auto lo = whole(box_.lo), hi = whole(box_.hi), p = whole(site);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int x = axis == 0 ? 1 : 0, y = axis == 1 ? 1 : 0, z = axis == 2 ? 1 : 0;
    planes_.push_back({x, y, z, lo[axis]});
    planes_.push_back({-x, -y, -z, -hi[axis]});
  }
  const Whole pp = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
  for (const Point& other : around) {
    const auto q = whole(other);
    const Whole qq = q[0] * q[0] + q[1] * q[1] + q[2] * q[2];
    planes_.push_back({2 * (p[0] - q[0]), 2 * (p[1] - q[1]), 2 * (p[2] - q[2]), pp - qq});
  }
  // Corner i has the upper side of axis k where bit k of i is set.
  for (std::size_t i = 0; i < 8; ++i)
    corners_.push_back({(i & 1) != 0 ? hi[0] : lo[0], (i & 2) != 0 ? hi[1] : lo[1], (i & 4) != 0 ? hi[2] : lo[2], 1});
  constexpr std::size_t rings[box_planes][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                                {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  for (std::size_t plane = 0; plane < box_planes; ++plane) faces_.push_back({plane, {rings[plane], rings[plane] + 4}});
}

BoxClipper::Corner BoxClipper::meet(std::size_t p, std::size_t q, std::size_t r) const {
  const Plane &l = planes_[p], &m = planes_[q], &n = planes_[r];
  Corner at{determinant({l.d, l.b, l.c}, {m.d, m.b, m.c}, {n.d, n.b, n.c}),
            determinant({l.a, l.d, l.c}, {m.a, m.d, m.c}, {n.a, n.d, n.c}),
            determinant({l.a, l.b, l.d}, {m.a, m.b, m.d}, {n.a, n.b, n.d}),
            determinant({l.a, l.b, l.c}, {m.a, m.b, m.c}, {n.a, n.b, n.c})};
  if (at.w < 0) at = {-at.x, -at.y, -at.z, -at.w};
  return at;
}

int BoxClipper::side(const Plane& plane, const Corner& corner) const {
  return sign_of(plane.a * corner.x + plane.b * corner.y + plane.c * corner.z - plane.d * corner.w);
}

std::vector<BoxClipper::Side> BoxClipper::sides() const {
  std::vector<Side> all;
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    const auto& ring = faces_[f].ring;
    for (std::size_t i = 0; i < ring.size(); ++i) all.push_back({ring[i], ring[(i + 1) % ring.size()], f});
  }
  std::sort(all.begin(), all.end());
  return all;
}

// Removes what is beyond the plane. False when nothing is left.
bool BoxClipper::cut(std::size_t plane) {
  std::vector<int> signs(corners_.size(), 0);
  bool any_in = false, any_out = false;
  for (const Face& face : faces_) {
    for (const std::size_t corner : face.ring) {
      signs[corner] = side(planes_[plane], corners_[corner]);
      any_in = any_in || signs[corner] > 0;
      any_out = any_out || signs[corner] < 0;
    }
  }
  if (!any_in) return false;
  if (!any_out) return true;
  cut_faces(plane, signs);
  close(plane);
  return true;
}

void BoxClipper::cut_faces(std::size_t plane, std::span<const int> signs) {
  const std::vector<Side> all = sides();
  made_.clear();
  std::vector<Face> left;
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    const auto& ring = faces_[f].ring;
    if (std::none_of(ring.begin(), ring.end(), [&](std::size_t corner) { return signs[corner] > 0; })) continue;
    Face face{faces_[f].plane, {}};
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const std::size_t a = ring[i], b = ring[(i + 1) % ring.size()];
      if (signs[a] >= 0) face.ring.push_back(a);
      if (signs[a] * signs[b] < 0) face.ring.push_back(corner_on(a, b, f, plane, all));
    }
    left.push_back(std::move(face));
  }
  faces_ = std::move(left);
}

// The corner where the plane cuts the side from a to b of a face.
std::size_t BoxClipper::corner_on(std::size_t a, std::size_t b, std::size_t face, std::size_t plane,
                                  std::span<const Side> all) {
  const std::array<std::size_t, 2> key{std::min(a, b), std::max(a, b)};
  for (const auto& [ends, corner] : made_)
    if (ends == key) return corner;
  const auto twin = std::lower_bound(all.begin(), all.end(), Side{b, a, 0});
  corners_.push_back(meet(faces_[face].plane, faces_[twin->face].plane, plane));
  made_.emplace_back(key, corners_.size() - 1);
  return corners_.size() - 1;
}

// Adds the face that the plane has made: its sides are the sides that only one face has.
void BoxClipper::close(std::size_t plane) {
  const std::vector<Side> all = sides();
  std::vector<std::array<std::size_t, 2>> open;  // sides of the new face
  for (const Side& one : all) {
    const auto twin = std::lower_bound(all.begin(), all.end(), Side{one.to, one.from, 0});
    if (twin == all.end() || twin->from != one.to || twin->to != one.from) open.push_back({one.to, one.from});
  }
  if (open.empty()) return;
  Face face{plane, {open[0][0]}};
  for (std::size_t at = open[0][1]; at != open[0][0] && face.ring.size() <= open.size();) {
    face.ring.push_back(at);
    const auto next = std::find_if(open.begin(), open.end(), [&](const auto& one) { return one[0] == at; });
    if (next == open.end()) break;
    at = (*next)[1];
  }
  faces_.push_back(std::move(face));
}

}  // namespace tessera::voronoi
