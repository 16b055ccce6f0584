// Bytes as calls to the kernels, 2D and 3D: the flat one must answer every one of them as CGAL's, and have a valid
// structure after each. Points come from small lattices of nine kinds, so that ties and hard signs are common.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <vector>

#include "src/geometry/predicates/independent/predicates.h"
#include "tests/kernel/differential.h"

namespace tessera::testing {
namespace {

constexpr unsigned kinds = 9;
constexpr std::size_t points_max = 64;  // CGAL takes a millisecond for a case of so many

class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : at_(data), end_(data + size) {}
  bool none() const { return at_ == end_; }
  std::uint8_t next() { return none() ? std::uint8_t{0} : *at_++; }

 private:
  const std::uint8_t *at_, *end_;
};

// What of the corners of a cell decides whether it is settled: anything that is the same for every kernel.
bool settled_by(std::uint8_t salt, const Vertex* v, std::size_t corners) {
  if (salt == 0) return true;
  std::uint64_t hash = salt;
  for (std::size_t i = 0; i < corners; ++i) hash = (hash ^ v[i]) * 0x9e3779b97f4a7c15u;
  return (hash >> 40 & (salt & 7)) != 0;
}

class Run {
 public:
  Run(const std::uint8_t* data, std::size_t size)
      : bytes_(data, size), header_(bytes_.next()), pair_((header_ & 2) != 0, dimension()) {}

  void go() {
    build();
    expect("build");
    while (!bytes_.none()) step();
  }

 private:
  int dimension() const { return header_ & 1 ? 3 : 2; }
  std::size_t corners() const { return static_cast<std::size_t>(dimension()) + 1; }
  bool full() const { return pair_.flat().dimension() == dimension(); }

  void expect(const char* what) {
    pair_.compare_cells();
    if (pair_.wrong().empty()) return;
    std::fprintf(stderr, "after %s: %s\n", what, pair_.wrong().c_str());
    std::abort();
  }

  // i is 0 to 7. Kinds 0 and 1 are exact; 2 to 4 round, as quantised data do; 5 and 6 underflow, 7 overflows when
  // squared; 8 has all magnitudes in one cloud.
  static double coordinate(unsigned kind, unsigned i) {
    const double x = i;
    switch (kind) {
      case 0:
        return x;
      case 1:
        return x - 4;
      case 2:
        return 0.1 * (x - 3);
      case 3:
        return 6.8e6 + 1e-3 * x;
      case 4:
        return i & 1 ? std::nextafter(x, 8) : x + 1;  // pairs that differ in the last bit
      case 5:
        return x * 0x1p-500;
      case 6:
        return x * 0x1p-1074;
      case 7:
        return (x - 3) * 1e300;
      default: {
        constexpr double scales[] = {0, 5e-324, 1e-300, 1e-20, 1, 6.8e6 + 1e-3, 1e20, 1e300};
        return scales[i];
      }
    }
  }

  // Two bytes: three bits a coordinate, one for the sign of y, one to swap x and y, four for a kind other than the
  // case's.
  Point point() {
    const unsigned low = bytes_.next(), bits = low | static_cast<unsigned>(bytes_.next()) << 8;
    const unsigned other = bits >> 12, kind = other > 0 && other < kinds ? other : (header_ >> 2 & 15) % kinds;
    const double sign = bits >> 9 & 1 ? -1 : 1;
    Point p{coordinate(kind, bits & 7), coordinate(kind, bits >> 3 & 7) * sign,
            dimension() == 2 ? 0 : coordinate(kind, bits >> 6 & 7)};
    if (bits >> 10 & 1) std::swap(p.x, p.y);
    return without_negative_zero(p);
  }

  void build() {
    const std::size_t n = bytes_.next() % (points_max / 2);
    built_.clear();
    for (std::size_t i = 0; i < n; ++i) {
      const Point p = point();
      if (std::find(built_.begin(), built_.end(), p) == built_.end()) built_.push_back(p);
    }
    pair_.build(built_, header_ & 64 ? KeepPoints::borrowed : KeepPoints::copied);
    froze_ = false;
  }

  bool has_frozen_cells(Vertex v) const {
    const auto& list = pair_.frozen().vertices;
    return std::find(list.begin(), list.end(), v) != list.end();
  }

  std::optional<Vertex> vertex_at(const Point& p) const {
    for (Vertex v = 1; v <= pair_.flat().vertices(); ++v) {
      if (pair_.flat().alive(v) && pair_.flat().point(v) == p) return v;
    }
    return {};
  }

  // What freeze() asks of later points.
  bool may_insert(const Point& p) const {
    if (pair_.flat().vertices() >= points_max) return false;
    if (const auto same = vertex_at(p)) return !has_frozen_cells(*same);
    const auto& list = pair_.frozen().vertices;
    for (std::size_t c = 0; c < list.size(); c += corners()) {
      const auto at = [&](std::size_t i) { return pair_.flat().point(list[c + i]); };
      const int side = dimension() == 2 ? independent::in_circle_perturbed_2(at(0), at(1), at(2), p)
                                        : independent::in_sphere_perturbed_3(at(0), at(1), at(2), at(3), p);
      if (side > 0) return false;
    }
    return true;
  }

  // What freeze() asks of later removals.
  bool may_remove(Vertex v) const {
    if (!pair_.flat().alive(v) || has_frozen_cells(v)) return false;
    std::vector<Vertex> around;
    pair_.flat().neighbours(v, around);
    return std::none_of(around.begin(), around.end(), [&](Vertex w) { return has_frozen_cells(w); });
  }

  bool settled(const Vertex* v) const { return settled_by(salt_, v, corners()); }

  // What freeze() asks of the cells that stay: from one of them all are reached through facets.
  bool open_cells_are_joined() const {
    const auto copy = make_kernel(dimension(), KernelKind::flat);
    copy->load(pair_.flat().save());
    CellList all;
    std::vector<std::uint8_t> open;
    const auto in_order = [&](const Vertex* v) {
      std::vector<Vertex> sorted(v, v + corners());
      std::sort(sorted.begin(), sorted.end());
      return settled(sorted.data());
    };
    copy->explore(in_order, &all, &open);
    std::vector<std::size_t> queue{static_cast<std::size_t>(std::find(open.begin(), open.end(), 1) - open.begin())};
    open[queue.front()] = 0;
    for (std::size_t next = 0; next < queue.size(); ++next) {
      for (std::size_t i = 0; i < corners(); ++i) {
        const std::uint32_t c = all.neighbors[corners() * queue[next] + i];
        if (open[c]) open[c] = 0, queue.push_back(c);
      }
    }
    return std::find(open.begin(), open.end(), 1) == open.end();
  }

  std::optional<Vertex> any_vertex() {
    const Vertex n = pair_.flat().vertices();
    if (n == 0) return {};
    return 1 + bytes_.next() % n;
  }

  void damage() {
    KernelImage image = pair_.flat().save();
    const std::uint8_t place = bytes_.next(), value = bytes_.next();
    auto& words = place & 1 ? image.cells.vertices : image.cells.neighbors;
    if (words.empty()) return;
    words[(place >> 1) * std::size_t{7} % words.size()] = value & 128 ? std::uint32_t{value} << 24 | value : value;
    make_kernel(dimension(), KernelKind::flat)->load(image);  // taken or refused, but no crash
  }

  void step() {
    const std::uint8_t op = bytes_.next();
    switch (op & 15) {
      default: {
        const Point p = point();
        if (may_insert(p)) pair_.insert(p, op & 16, op & 32 ? InsertMode::always : InsertMode::if_local_neighbour);
        return expect("insert");
      }
      case 8:
      case 9: {
        const auto v = any_vertex();
        if (v && may_remove(*v)) pair_.remove(*v);
        return expect("remove");
      }
      case 10: {
        const auto v = any_vertex();
        if (v && !has_frozen_cells(*v)) pair_.compare_star(*v);
        return expect("star");
      }
      case 11: {
        // After freezing only the same question: CGAL's kernel still has all cells.
        if (!froze_) salt_ = bytes_.next();
        pair_.compare_open([&](const Vertex* v) { return settled(v); });
        return expect("explore");
      }
      case 12: {
        if (froze_ || !full()) return;
        salt_ = bytes_.next();
        if (!open_cells_are_joined()) return;
        pair_.freeze([&](const Vertex* v) { return settled(v); });
        froze_ = true;
        return expect("freeze");
      }
      case 13: {
        if (op & 16 && !froze_) {
          pair_.exchange();
        } else {
          pair_.save_and_load();
        }
        return expect("save and load");
      }
      case 14:
        return damage();
      case 15: {
        build();
        return expect("build");
      }
    }
  }

  Bytes bytes_;
  std::uint8_t header_;
  KernelPair pair_;
  std::vector<Point> built_;  // the kernels may have borrowed them
  bool froze_ = false;        // since the last build
  std::uint8_t salt_ = 0;
};

}  // namespace
}  // namespace tessera::testing

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  tessera::testing::Run(data, size).go();
  return 0;
}
