// The innermost loops: the conflict zone of a point, and the walk to it. Cells are asked four at a time, one in each
// vector lane, and no branch depends on an answer. The vectors are types of the compiler, so the same code runs on
// every machine. Where the processor has AVX2, a second copy of the code is used.
#include <algorithm>
#include <cstring>

#include "src/geometry/kernel/flat/mesh_3.h"
#include "src/geometry/kernel/flat/predicates_3.h"

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wpsabi"  // the functions that take vectors are always inlined
#endif

namespace tessera::flat3 {
namespace {

using Lanes = double __attribute__((vector_size(32)));
using Bits = std::int64_t __attribute__((vector_size(32)));
using Quad = Index __attribute__((vector_size(16)));

[[gnu::always_inline]] inline Lanes absolute(Lanes x) {
  const Bits mask = {INT64_MAX, INT64_MAX, INT64_MAX, INT64_MAX};
  return reinterpret_cast<Lanes>(reinterpret_cast<Bits>(x) & mask);
}
[[gnu::always_inline]] inline Lanes larger(Lanes a, Lanes b) { return a > b ? a : b; }

// The lanes of the first 0, 1, 2, 3 or 4 cells.
constexpr Bits lanes_used[5] = {{}, {-1, 0, 0, 0}, {-1, -1, 0, 0}, {-1, -1, -1, 0}, {-1, -1, -1, -1}};

// The differences of four points to a query, one point to a lane, and their squared lengths w.
struct Differences {
  Lanes x, y, z, w;
};

[[gnu::always_inline]] inline Differences differences(const Point& a, const Point& b, const Point& c, const Point& d,
                                                      const Point& e) {
  Differences r;
  r.x = Lanes{a.x, b.x, c.x, d.x} - e.x;
  r.y = Lanes{a.y, b.y, c.y, d.y} - e.y;
  r.z = Lanes{a.z, b.z, c.z, d.z} - e.z;
  r.w = r.x * r.x + r.y * r.y + r.z * r.z;
  return r;
}

}  // namespace

struct ZoneCode {
  // Up to four cells that are asked together.
  struct Four {
    Index facet[4];  // the cells, with the facets through which they were reached; spare lanes repeat the first
    std::size_t size;
    bool special;  // whether one of the cells is infinite
    Bits in, sure;
  };

  // Asks whether e is in the spheres of four cells. The answer for an infinite cell is meaningless.
  template <class At>
  [[gnu::always_inline]] static void ask(Four& four, const Cell* cells, const At& at, const Point& e) {
    Index v[4][4];
    bool special = false;
    for (int i = 0; i < 4; ++i) {
      const Cell& c = cell_at(cells, four.facet[i]);
      v[i][0] = c.v[0] & vertex_mask;
      v[i][1] = c.v[1];
      v[i][2] = c.v[2];
      v[i][3] = c.infinite() ? v[i][0] : c.v[3];  // any point will do: the answer is not used
      special |= c.infinite();
    }
    four.special = special;
    const auto slot = [&](int k) __attribute__((always_inline)) {
      return differences(at(v[0][k]), at(v[1][k]), at(v[2][k]), at(v[3][k]), e);
    };
    const Differences a = slot(0), b = slot(1), c = slot(2), d = slot(3);
    const Lanes ab = a.x * b.y - b.x * a.y, bc = b.x * c.y - c.x * b.y, cd = c.x * d.y - d.x * c.y;
    const Lanes da = d.x * a.y - a.x * d.y, ac = a.x * c.y - c.x * a.y, bd = b.x * d.y - d.x * b.y;
    const Lanes abc = a.z * bc - b.z * ac + c.z * ab, bcd = b.z * cd - c.z * bd + d.z * bc;
    const Lanes cda = c.z * da + d.z * ac + a.z * cd, dab = d.z * ab + a.z * bd + b.z * da;
    const Lanes det = (a.w * bcd - b.w * cda) + (c.w * dab - d.w * abc);
    const auto largest = [](Lanes p, Lanes q, Lanes r, Lanes s) __attribute__((always_inline)) {
      return larger(larger(absolute(p), absolute(q)), larger(absolute(r), absolute(s)));
    };
    const Lanes w = larger(larger(a.w, b.w), larger(c.w, d.w));
    const Lanes error =
        in_sphere_error * largest(a.x, b.x, c.x, d.x) * largest(a.y, b.y, c.y, d.y) * largest(a.z, b.z, c.z, d.z) * w +
        underflow;
    four.in = det > error;
    four.sure = (absolute(det) > error) & (w < exact::filter::lift_max);
  }

  template <bool split, bool holes>
  [[gnu::always_inline]] static void collect(Mesh& m, const Point& e, Index start) {
    Cell* const cells = m.cells.data();
    const Point* const points = m.points.first();
    const auto at = [&](Index v) -> const Point& {
      if constexpr (split) return m.points[v];
      return points[v];
    };
    std::size_t found = 1, expanded = 0, met = 0, asked = 0;
    if (m.zone_.size() < 1024) m.zone_.resize(1024), m.pending_.resize(4096);
    m.zone_[0] = 4 * start;
    cells[start].v[0] |= mark_in;
    // Two groups of four are in work: while the determinants of one are computed, the code acts on the answers of the
    // group before. The next work depends on the answers, and the processor often predicts it wrong. In this way it
    // finds out early.
    Four fours[2];
    std::size_t turn = 0;
    bool waiting = false;  // the answers of fours[turn] have not been used yet
    // The number of zone cells for which there is room. pending_ needs four entries a zone cell. zone_ may also have
    // grown elsewhere.
    std::size_t room = std::min(m.zone_.size(), m.pending_.size() / 4);
    Index* zone = m.zone_.data();
    Index* pending = m.pending_.data();
    while (true) {
      if (found + 16 > room) {  // one turn adds less
        room *= 2;
        if (m.zone_.size() < room) m.zone_.resize(room);
        m.pending_.resize(4 * room);
        zone = m.zone_.data();
        pending = m.pending_.data();
      }
      const auto act = [&](Four & four) __attribute__((always_inline)) {
        if (four.special | ~(four.sure[0] & four.sure[1] & four.sure[2] & four.sure[3])) [[unlikely]] {
          for (std::size_t i = 0; i < four.size; ++i) {
            if (!four.sure[i] || cell_at(cells, four.facet[i]).infinite()) {
              four.in[i] = m.conflicts(e, four.facet[i] >> 2) ? -1 : 0;
            }
          }
        }
        for (std::size_t i = 0; i < 4; ++i) {
          const Index in = static_cast<Index>(four.in[i]);  // all bits or none are set
          zone[found] = four.facet[i];
          found += in & 1;
          cell_at(cells, four.facet[i]).v[0] ^= in & (mark_in | mark_out);
        }
      };
      const auto expand = [&](std::size_t count) __attribute__((always_inline)) {
        for (std::size_t k = 0; k < count; ++k) {
          const Cell& c = cell_at(cells, zone[expanded++]);
          for (int i = 0; i < 4; ++i) {
            const Index across = c.n[i];
            if constexpr (holes) {
              if (across & frozen_bit) continue;
            }
            Cell& next = cell_at(cells, across);
            const Index v0 = next.v[0];
            const bool fresh = v0 <= vertex_mask;
            next.v[0] = fresh ? v0 | mark_out : v0;
            pending[met] = across;
            met += fresh;
            for (int j = 0; j < 4; ++j) __builtin_prefetch(&cell_at(cells, next.n[j]));
          }
        }
      };
      // As long as there are enough cells, a turn expands a fixed number of them, because that is easy to predict.
      if (found - expanded >= 2) {
        expand(2);
        if (met - asked < 4) continue;
      } else if (met - asked < 4) {
        if (waiting) {
          act(fours[turn]);
          waiting = false;
        }
        expand(found - expanded);
        if (asked == met) break;
      }
      Four& four = fours[turn ^ 1];
      const std::size_t left = met - asked;
      four.size = left < 4 ? left : 4;
      // What follows the last pending cell is overwritten later.
      for (std::size_t i = 0; i < 3; ++i) pending[met + i] = pending[asked];
      for (std::size_t i = 0; i < 4; ++i) four.facet[i] = pending[asked + i];
      asked += four.size;
      ask(four, cells, at, e);
      four.in &= lanes_used[four.size];
      if (waiting) act(fours[turn]);
      turn ^= 1;
      waiting = true;
    }
    m.zone_size_ = found;
    bound<holes>(m, cells);
  }

  template <bool holes>
  static std::size_t boundary_facets(const Mesh& m, const Cell* cells) {
    std::size_t facets = 0;
    for (std::size_t z = 0; z < m.zone_size_; ++z) {
      for (const Index across : cell_at(cells, m.zone_[z]).n) {
        facets += (holes && (across & frozen_bit)) || cell_at(cells, across).v[0] >> 31;
      }
    }
    return facets;
  }

  // Numbers the zone's vertices and lists its boundary: the facets across which the cell is not in the zone.
  template <bool holes>
  [[gnu::always_inline]] static void bound(Mesh& m, const Cell* cells) {
    const std::size_t found = m.zone_size_;
    // `found` cells that are joined through facets have at most 2 found + 2 other facets, and one entry more is written
    // than listed. For a large zone the boundary is counted first, because most of its facets may be inside.
    if (found > Mesh::usual_zone) [[unlikely]] {
      const std::size_t facets = boundary_facets<holes>(m, cells) + 1;
      if (facets > m.facets_.size()) m.facets_.resize(facets);
    } else if (2 * found + 3 > m.facets_.size()) {
      m.facets_.resize(3 * found + 64);
    }
    if (found + 8 > m.zone_vertices_.size()) m.zone_vertices_.resize(2 * found + 64);
    Vertex* const vertices = m.zone_vertices_.data();
    std::uint8_t* const number = m.number_.data();
    const Index* const zone = m.zone_.data();
    std::size_t numbered = 0;
    const auto meet = [&](Vertex v) __attribute__((always_inline)) {
      const std::uint8_t old = number[v];
      vertices[numbered] = v;
      numbered += old == 0;
      number[v] = old != 0 ? old : static_cast<std::uint8_t>(numbered < 255 ? numbered : 255);
    };
    Mesh::Facet* facet = m.facets_.data();
    for (std::size_t z = 0; z < found; ++z) {
      const Cell& c = cell_at(cells, zone[z]);
      const Quad corner = Quad{c.v[0], c.v[1], c.v[2], c.v[3]} & Quad{vertex_mask, ~0u, ~0u, ~0u};
      const Quad next = {c.n[0], c.n[1], c.n[2], c.n[3]};
      if (z == 0) {
        for (int i = 0; i < 4; ++i) meet(corner[i]);
      } else {  // the other three vertices belong to an earlier cell, too
        meet(c.v[zone[z] & 3] & vertex_mask);
      }
      const Quad id = {number[corner[0]], number[corner[1]], number[corner[2]], number[corner[3]]};
      const auto list = [&]<int i, int... corners>() __attribute__((always_inline)) {
        const Index across = c.n[i];
        Index outside;  // every cell next to the zone is marked with one of the two bits
        if constexpr (holes) {
          outside = across & frozen_bit ? 1 : cell_at(cells, across).v[0] >> 31;
        } else {
          outside = cell_at(cells, across).v[0] >> 31;
        }
        const Quad v = __builtin_shufflevector(corner, next, corners..., 4 + i),
                   n = __builtin_shufflevector(id, id, corners..., 3);
        std::memcpy(facet->v, &v, sizeof v);
        std::memcpy(facet->number, &n, sizeof n);
        facet += outside;
      };
      list.template operator()<0, 1, 2, 3>();
      list.template operator()<1, 2, 0, 3>();
      list.template operator()<2, 0, 1, 3>();
      list.template operator()<3, 2, 1, 0>();
    }
    m.facets_size_ = static_cast<std::size_t>(facet - m.facets_.data());
    m.zone_vertices_size_ = numbered;
  }

  // Continues a walk as long as all signs are certain, and the next cell is finite and not frozen. Four facets are
  // asked at once, and the next cell is computed without a branch. WalkStep says what the walk starts with.
  template <bool split>
  [[gnu::always_inline]] static Mesh::WalkStep walk(const Mesh& m, const Point& p, Mesh::WalkStep step) {
    const Cell* const cells = m.cells.data();
    const Point* const points = m.points.first();
    const auto at = [&](Index v) -> const Point& {
      if constexpr (split) return m.points[v];
      return points[v];
    };
    Index random = m.turn_;
    while (true) {
      const Cell& c = cells[step.slot];
      if (c.infinite()) return {step.slot, step.from, true};
      const Point &a = at(c.v[0]), &b = at(c.v[1]), &d = at(c.v[2]), &e = at(c.v[3]);
      const Lanes x = Lanes{a.x, b.x, d.x, e.x} - p.x, y = Lanes{a.y, b.y, d.y, e.y} - p.y;
      const Lanes z = Lanes{a.z, b.z, d.z, e.z} - p.z;
      // Lane i is facet i, with the corners of facet_of.
      const Lanes ax = __builtin_shufflevector(x, x, 1, 2, 0, 2), bx = __builtin_shufflevector(x, x, 2, 0, 1, 1);
      const Lanes cx = __builtin_shufflevector(x, x, 3, 3, 3, 0);
      const Lanes ay = __builtin_shufflevector(y, y, 1, 2, 0, 2), by = __builtin_shufflevector(y, y, 2, 0, 1, 1);
      const Lanes cy = __builtin_shufflevector(y, y, 3, 3, 3, 0);
      const Lanes az = __builtin_shufflevector(z, z, 1, 2, 0, 2), bz = __builtin_shufflevector(z, z, 2, 0, 1, 1);
      const Lanes cz = __builtin_shufflevector(z, z, 3, 3, 3, 0);
      const Lanes det = ax * (by * cz - bz * cy) + bx * (cy * az - cz * ay) + cx * (ay * bz - az * by);
      const auto most = [](Lanes q) __attribute__((always_inline)) {
        q = absolute(q);
        q = larger(q, __builtin_shufflevector(q, q, 2, 3, 0, 1));
        return larger(q, __builtin_shufflevector(q, q, 1, 0, 3, 2));
      };
      const Lanes mx = most(x), my = most(y), mz = most(z);
      const Lanes error = orientation_error * mx * my * mz + underflow;
      const Lanes largest = larger(larger(mx, my), mz);
      const Bits behind = det < -error, sure = (absolute(det) > error) & (largest < exact::filter::difference_max);
      Bits flags = (behind & Bits{1, 2, 4, 8}) | (~sure & Bits{16, 32, 64, 128});
      flags |= __builtin_shufflevector(flags, flags, 2, 3, 0, 1);
      flags |= __builtin_shufflevector(flags, flags, 1, 0, 3, 2);
      const Index seen = static_cast<Index>(flags[0]) & ~(0x11u << step.from);
      if (seen >> 4) [[unlikely]]
        return step;
      if (seen == 0) return {step.slot, step.from, true};
      // The first facet to try is random, because a fixed order leads around in spirals.
      random = random * 5 + 1;
      const Index turn = random >> 16 & 3;
      const Index i = (static_cast<Index>(__builtin_ctz((seen | seen << 4) >> turn)) + turn) & 3;
      const Index across = c.n[i];
      if (across & frozen_bit) [[unlikely]]
        return step;
      step = {across >> 2, across & 3, false};
    }
  }
  [[gnu::always_inline]] static Mesh::WalkStep choose_walk(const Mesh& m, const Point& p, Mesh::WalkStep step) {
    return m.points.in_one_piece() ? walk<false>(m, p, step) : walk<true>(m, p, step);
  }

  [[gnu::always_inline]] static void choose(Mesh& m, const Point& e, Index start) {
    if (m.frozen_) {
      collect<true, true>(m, e, start);
    } else if (m.points.in_one_piece()) {
      collect<false, false>(m, e, start);
    } else {
      collect<true, false>(m, e, start);
    }
  }
  static void plain(Mesh& m, const Point& e, Index start) { choose(m, e, start); }
  static Mesh::WalkStep walk_plain(const Mesh& m, const Point& p, Mesh::WalkStep step) {
    return choose_walk(m, p, step);
  }
#if defined(__x86_64__)
  [[gnu::target("avx2")]] static void avx2(Mesh& m, const Point& e, Index start) { choose(m, e, start); }
  [[gnu::target("avx2")]] static Mesh::WalkStep walk_avx2(const Mesh& m, const Point& p, Mesh::WalkStep step) {
    return choose_walk(m, p, step);
  }
  static bool has_avx2() { return __builtin_cpu_supports("avx2"); }
#else
  static void avx2(Mesh& m, const Point& e, Index start) { choose(m, e, start); }
  static Mesh::WalkStep walk_avx2(const Mesh& m, const Point& p, Mesh::WalkStep step) {
    return choose_walk(m, p, step);
  }
  static bool has_avx2() { return false; }
#endif
};

void Mesh::find_zone(const Point& p, Index start) {
  newest_ = none;
  before_zone();
  reserve_numbers();
  if (vectors_) {
    ZoneCode::avx2(*this, p, start);
  } else {
    ZoneCode::plain(*this, p, start);
  }
  after_zone(zone_size_);
}

Mesh::WalkStep Mesh::walk_surely(const Point& p, WalkStep step) const {
  return vectors_ ? ZoneCode::walk_avx2(*this, p, step) : ZoneCode::walk_plain(*this, p, step);
}

Mesh::Mesh(const FlatOptions& options)
    : MeshBase(options, vertices_max), vectors_(options.vectors && ZoneCode::has_avx2()) {}

}  // namespace tessera::flat3
