// The innermost loop: which cells are in conflict with a point. Cells are asked four at a time, one to a vector lane,
// and no branch depends on an answer. The vectors are the compiler's own, so the same code runs on every machine; where
// AVX2 is present a second copy of it is used.
#include <cstring>

#include "src/kernel/flat_mesh_3.h"
#include "src/kernel/flat_predicates_3.h"

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wpsabi"  // vectors are passed to functions that are always inlined
#endif

namespace tessera::flat {
namespace {

using Lanes = double __attribute__((vector_size(32)));
using Bits = std::int64_t __attribute__((vector_size(32)));

[[gnu::always_inline]] inline Lanes absolute(Lanes x) {
  const Bits mask = {INT64_MAX, INT64_MAX, INT64_MAX, INT64_MAX};
  return reinterpret_cast<Lanes>(reinterpret_cast<Bits>(x) & mask);
}
[[gnu::always_inline]] inline Lanes larger(Lanes a, Lanes b) { return a > b ? a : b; }

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
  template <bool split, bool holes>
  [[gnu::always_inline]] static void collect(Mesh& m, const Point& e, Word start) {
    Cell* const cells = m.cells.data();
    const auto at = [&](Word v) -> const Point& {
      if constexpr (split) return m.points[v];
      return m.points.first(v);
    };
    std::size_t found = 1, expanded = 0, met = 0, asked = 0;
    if (m.zone_.size() < 1024) m.zone_.resize(1024), m.pending_.resize(4096);
    m.zone_[0] = start;
    cells[start].v[0] |= mark_in;
    while (true) {
      if (found + 4 > m.zone_.size()) m.zone_.resize(2 * m.zone_.size());
      if (met + 4 * (found - expanded) + 4 > m.pending_.size()) m.pending_.resize(2 * m.pending_.size() + 4 * found);
      Word* const zone = m.zone_.data();
      Word* const pending = m.pending_.data();
      for (; expanded < found; ++expanded) {
        const Cell& c = cells[zone[expanded]];
        for (int i = 0; i < 4; ++i) {
          const Word across = c.n[i];
          if constexpr (holes) {
            if (across & frozen_bit) continue;
          }
          Cell& next = cells[across >> 2];
          const Word v0 = next.v[0];
          const bool fresh = v0 <= vertex_mask;
          next.v[0] = fresh ? v0 | mark_out : v0;
          pending[met] = across >> 2;
          met += fresh;
        }
      }
      if (asked == met) break;
      Word batch[4];
      const std::size_t left = met - asked;
      for (std::size_t i = 0; i < 4; ++i) batch[i] = pending[asked + (i < left ? i : 0)];
      Word v[4][4];
      for (int i = 0; i < 4; ++i) {
        const Cell& c = cells[batch[i]];
        v[i][0] = c.v[0] & vertex_mask;
        v[i][1] = c.v[1];
        v[i][2] = c.v[2];
        v[i][3] = c.infinite() ? v[i][0] : c.v[3];  // any point: the lane is not used
      }
      const auto slot = [&](int k) { return differences(at(v[0][k]), at(v[1][k]), at(v[2][k]), at(v[3][k]), e); };
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
          in_sphere_error * largest(a.x, b.x, c.x, d.x) * largest(a.y, b.y, c.y, d.y) * largest(a.z, b.z, c.z, d.z) * w;
      const Bits sure = (absolute(det) > error) & (error > in_sphere_least) & (w < in_sphere_most);
      const std::size_t used = left < 4 ? left : 4;
      for (std::size_t i = 0; i < used; ++i) {
        Cell& asked_cell = cells[batch[i]];
        bool in = det[i] > 0;
        if (!sure[i] || asked_cell.infinite()) [[unlikely]]
          in = m.conflicts(e, batch[i]);
        zone[found] = batch[i];
        found += in;
        asked_cell.v[0] ^= in ? mark_in | mark_out : 0;
      }
      asked += used;
    }
    m.zone_size_ = found;
    // The boundary: facets of the zone across which a cell is not in it.
    if (4 * found + 4 > m.facets_.size()) m.facets_.resize(8 * found + 64);
    Mesh::Facet* facet = m.facets_.data();
    for (std::size_t z = 0; z < found; ++z) {
      const Cell& c = cells[m.zone_[z]];
      const Word corner[4] = {c.v[0] & vertex_mask, c.v[1], c.v[2], c.v[3]};
      for (int i = 0; i < 4; ++i) {
        const Word across = c.n[i];
        bool outside;
        if constexpr (holes) {
          outside = across & frozen_bit || (cells[across >> 2].v[0] & ~vertex_mask) == mark_out;
        } else {
          outside = (cells[across >> 2].v[0] & ~vertex_mask) == mark_out;
        }
        *facet = {{corner[facet_of[i][0]], corner[facet_of[i][1]], corner[facet_of[i][2]]}, across};
        facet += outside;
      }
    }
    m.facets_size_ = static_cast<std::size_t>(facet - m.facets_.data());
  }

  [[gnu::always_inline]] static void choose(Mesh& m, const Point& e, Word start) {
    if (m.frozen_) {
      collect<true, true>(m, e, start);
    } else if (m.points.in_one_piece()) {
      collect<false, false>(m, e, start);
    } else {
      collect<true, false>(m, e, start);
    }
  }
  static void plain(Mesh& m, const Point& e, Word start) { choose(m, e, start); }
#if defined(__x86_64__)
  [[gnu::target("avx2")]] static void avx2(Mesh& m, const Point& e, Word start) { choose(m, e, start); }
  static bool has_avx2() { return __builtin_cpu_supports("avx2"); }
#else
  static void avx2(Mesh& m, const Point& e, Word start) { choose(m, e, start); }
  static bool has_avx2() { return false; }
#endif
};

void Mesh::find_zone(const Point& p, Word start) {
  if (vectors_) {
    ZoneCode::avx2(*this, p, start);
  } else {
    ZoneCode::plain(*this, p, start);
  }
  number_vertices();
}

void Mesh::use_vectors(bool wanted) { vectors_ = wanted && ZoneCode::has_avx2(); }

}  // namespace tessera::flat
