// Cuts a cell by planes of the grid.
//
// A shape is a part of the cell. Its corners are given by their barycentric coordinates, the weights of the cell's
// vertices, so a flat cell is cut as well as a regular one: the weights are between 0 and 1, and the volume of a shape
// is a fraction of the volume of the cell. Which corners a shape has follows from the signs of their distances from
// planes alone. A corner on a plane counts as above and as below it, and may come twice; that changes no volume. The
// two parts of a cut edge get the same new corner, so that the parts of a cell fill it without gaps.
// Source: Powell, Abel, An exact general remeshing scheme applied to physically conservative voxelization, Journal of
// Computational Physics 297 (2015). Their shapes have coordinates in space.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace tessera::density {

// One number for each vertex of the cell.
template <class Number, std::size_t corners>
using Weights = std::array<Number, corners>;

// Takes up a weighted mean of `distances`, which are those of the cell's vertices from a plane.
template <class Number, std::size_t corners>
Number mean_of(const Weights<Number, corners>& weights, const Weights<Number, corners>& distances) {
  Number sum = weights[0] * distances[0];
  for (std::size_t k = 1; k < corners; ++k) sum += weights[k] * distances[k];
  return sum;
}

// The point of an edge at which the distance is 0. Gives the same bits when a and b are swapped, or both signs change.
template <class Number, std::size_t corners>
Weights<Number, corners> crossing(const Weights<Number, corners>& a, const Number& at_a,
                                  const Weights<Number, corners>& b, const Number& at_b) {
  Weights<Number, corners> made;
  const Number whole = at_b - at_a;
  for (std::size_t k = 0; k < corners; ++k) made[k] = (a[k] * at_b - b[k] * at_a) / whole;
  return made;
}

// A convex part of a triangle: its corners in order.
template <class Number>
class Polygon {
 public:
  static constexpr std::size_t corners = 3;
  using Corner = Weights<Number, corners>;

  static Polygon whole() {
    Polygon shape;
    shape.corners_ = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    return shape;
  }
  bool empty() const { return corners_.empty(); }
  const std::vector<Corner>& points() const { return corners_; }

  // Keeps what is above the plane, or below it.
  void clip(const Corner& distances, bool above) {
    std::vector<Number> at(corners_.size());
    for (std::size_t i = 0; i < at.size(); ++i) {
      at[i] = mean_of(corners_[i], distances);
      if (!above) at[i] = -at[i];
    }
    std::vector<Corner> kept;
    for (std::size_t i = 0; i < at.size(); ++i) {
      const std::size_t next = i + 1 == at.size() ? 0 : i + 1;
      if (at[i] >= 0) kept.push_back(corners_[i]);
      if ((at[i] >= 0) != (at[next] >= 0)) kept.push_back(crossing(corners_[i], at[i], corners_[next], at[next]));
    }
    corners_ = std::move(kept);
  }

  // The integrals of the weights over the shape, as fractions of the cell's volume.
  Corner integrals() const {
    Corner sums{};
    for (std::size_t i = 1; i + 1 < corners_.size(); ++i) {
      const Corner &a = corners_[0], &b = corners_[i], &c = corners_[i + 1];
      const Number part = ((b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1])) / 3;
      for (std::size_t k = 0; k < corners; ++k) sums[k] += part * (a[k] + b[k] + c[k]);
    }
    return sums;
  }

 private:
  std::vector<Corner> corners_;
};

// A convex part of a tetrahedron: its corners, and its faces as loops of corners.
template <class Number>
class Polyhedron {
 public:
  static constexpr std::size_t corners = 4;
  using Corner = Weights<Number, corners>;

  static Polyhedron whole() {
    Polyhedron shape;
    shape.corners_ = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
    shape.loops_ = {1, 2, 3, 0, 3, 2, 0, 1, 3, 0, 2, 1};  // seen from inside counterclockwise
    shape.ends_ = {3, 6, 9, 12};
    return shape;
  }
  bool empty() const { return ends_.empty(); }
  const std::vector<Corner>& points() const { return corners_; }

  void clip(const Corner& distances, bool above) {
    std::vector<Number> at(corners_.size());
    bool cut = false;
    for (std::size_t i = 0; i < at.size(); ++i) {
      at[i] = mean_of(corners_[i], distances);
      if (!above) at[i] = -at[i];
      cut = cut || !(at[i] >= 0);
    }
    if (!cut) return;
    Cut made;
    std::size_t begin = 0;
    for (const std::size_t end : ends_) {
      cut_loop(begin, end, at, made);
      begin = end;
    }
    made.close(corners_.size());
    corners_.insert(corners_.end(), made.corners.begin(), made.corners.end());
    loops_ = std::move(made.loops);
    ends_ = std::move(made.ends);
    drop_unused();
  }

  Corner integrals() const {
    Corner sums{};
    if (empty()) return sums;
    // Tetrahedra from one corner over the triangles of all faces. Those of the corner's own faces have no volume.
    const Corner& a = corners_[loops_[0]];
    std::size_t begin = 0;
    for (const std::size_t end : ends_) {
      const Corner& b = corners_[loops_[begin]];
      for (std::size_t i = begin + 1; i + 1 < end; ++i) {
        const Corner &c = corners_[loops_[i]], &d = corners_[loops_[i + 1]];
        if (&a == &b || &a == &c || &a == &d) continue;
        const Number part = determinant(a, b, c, d) / 4;
        for (std::size_t k = 0; k < corners; ++k) sums[k] += part * (a[k] + b[k] + c[k] + d[k]);
      }
      begin = end;
    }
    return sums;
  }

 private:
  using Index = std::uint16_t;

  // What becomes of a shape that is cut.
  struct Cut {
    struct Edge {
      Index kept, lost, corner;
    };
    std::vector<Edge> edges;      // edges that are cut, each once
    std::vector<Corner> corners;  // new ones
    std::vector<Index> loops;
    std::vector<std::size_t> ends;
    std::vector<Index> next;  // by new corner: the next one around the face on the plane

    void end_loop(std::size_t begin) {
      if (loops.size() - begin < 3)
        loops.resize(begin);
      else
        ends.push_back(loops.size());
    }
    // Adds the face on the plane. Each new corner is where one face enters the kept side and another leaves it, so
    // `next` is a permutation.
    void close(std::size_t old) {
      std::vector<bool> done(next.size());
      for (std::size_t first = 0; first < next.size(); ++first) {
        if (done[first]) continue;
        const std::size_t begin = loops.size();
        for (std::size_t i = first; !done[i]; i = next[i] - old) {
          done[i] = true;
          loops.push_back(static_cast<Index>(old + i));
        }
        end_loop(begin);
      }
    }
  };

  Index corner_on(Index kept, Index lost, const std::vector<Number>& at, Cut& made) const {
    for (const auto& edge : made.edges)
      if (edge.kept == kept && edge.lost == lost) return edge.corner;
    const auto corner = static_cast<Index>(corners_.size() + made.corners.size());
    made.edges.push_back({kept, lost, corner});
    made.corners.push_back(crossing(corners_[kept], at[kept], corners_[lost], at[lost]));
    made.next.push_back(corner);
    return corner;
  }

  void cut_loop(std::size_t begin, std::size_t end, const std::vector<Number>& at, Cut& made) const {
    const std::size_t out = made.loops.size();
    // Where the loop has left the kept side; it enters again at a later corner, or at one before the first exit.
    std::vector<std::pair<bool, Index>> crossings;  // (whether the loop enters, corner)
    for (std::size_t i = begin; i < end; ++i) {
      const Index a = loops_[i], b = loops_[i + 1 == end ? begin : i + 1];
      const bool a_in = at[a] >= 0, b_in = at[b] >= 0;
      if (a_in) made.loops.push_back(a);
      if (a_in == b_in) continue;
      const Index corner = a_in ? corner_on(a, b, at, made) : corner_on(b, a, at, made);
      made.loops.push_back(corner);
      crossings.emplace_back(b_in, corner);
    }
    // The face on the plane goes the other way, from where the loop enters to where it has left before.
    for (std::size_t i = 0; i < crossings.size(); ++i) {
      if (!crossings[i].first) continue;
      const auto& before = crossings[i == 0 ? crossings.size() - 1 : i - 1];
      made.next[crossings[i].second - corners_.size()] = before.second;
    }
    made.end_loop(out);
  }

  void drop_unused() {
    std::vector<Index> number(corners_.size(), 0);
    for (const Index i : loops_) number[i] = 1;
    Index used = 0;
    for (std::size_t i = 0; i < number.size(); ++i) {
      if (number[i] == 0) continue;
      corners_[used] = corners_[i];
      number[i] = used++;
    }
    corners_.resize(used);
    for (Index& i : loops_) i = number[i];
  }

  static Number determinant(const Corner& a, const Corner& b, const Corner& c, const Corner& d) {
    const auto e = [&](const Corner& to, std::size_t k) -> Number { return to[k] - a[k]; };
    return e(b, 1) * (e(c, 2) * e(d, 3) - e(c, 3) * e(d, 2)) + e(b, 2) * (e(c, 3) * e(d, 1) - e(c, 1) * e(d, 3)) +
           e(b, 3) * (e(c, 1) * e(d, 2) - e(c, 2) * e(d, 1));
  }

  std::vector<Corner> corners_;
  std::vector<Index> loops_;       // one after the other
  std::vector<std::size_t> ends_;  // of the loops
};

}  // namespace tessera::density
