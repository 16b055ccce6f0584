// The code that the 2D and the 3D kernel of CGAL share. `Traits` hides the differences between CGAL's two interfaces:
//   Triangulation, Cell (a handle), Vertex_h (a handle), d
//   to_cgal(Point), from_cgal(CGAL point)
//   for_each_cell(t, f), for_each_incident_cell(t, v, f), for_each_neighbour(t, v, f)
//   Zone: the conflict zone of a point, with a member `cells` and clear()
//   conflicts(t, p, start, zone): locates p and collects its conflict zone; returns the vertex at p, or null
//   make_room(t): called before each insertion; gets memory that the insertion must not fail to get halfway
//   insert_into(t, p, zone): inserts p
//   create_cell(t, vertices), set_neighbours(cell, neighbours)
#pragma once

#include <array>
#include <cassert>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "src/base/check.h"
#include "src/base/stopped.h"
#include "src/geometry/kernel/brio.h"
#include "src/geometry/kernel/kernel.h"

namespace tessera {

// A cell of CGAL with fields for a mark and a number.
template <class Base>
class Indexed : public Base {
 public:
  using Base::Base;
  template <class Tds>
  struct Rebind_TDS {
    using Other = Indexed<typename Base::template Rebind_TDS<Tds>::Other>;
  };
  std::uint8_t mark = 0;
  std::uint32_t number = 0;
};

template <class Traits>
class CgalKernel final : public Kernel {
 public:
  using Triangulation = typename Traits::Triangulation;
  using Handle = typename Traits::Vertex_h;
  using Cell = typename Traits::Cell;
  static constexpr int d = Traits::d;

  CgalKernel() { reset(); }

  int max_dimension() const override { return d; }
  int dimension() const override { return t_.dimension(); }
  Vertex vertices() const override { return static_cast<Vertex>(handles_.size() - 1); }
  Point point(Vertex v) const override { return Traits::from_cgal(handles_[v]->point()); }
  bool is_local(Vertex v) const override { return local_[v] != 0; }
  bool alive(Vertex v) const override { return handles_[v] != Handle(); }

  void build(std::span<const Point> points, KeepPoints, const std::stop_token& stop) override {
    reset();
    handles_.resize(points.size() + 1);
    local_.assign(points.size() + 1, 1);
    local_[0] = 0;
    Cell hint{};
    for_each_in_brio_order(points.size(), [&](std::size_t i) {
      Traits::make_room(t_);
      const Handle v = t_.insert(Traits::to_cgal(points[i]), hint);
      hint = Traits::cell_of(v);
      v->info() = static_cast<Vertex>(i + 1);
      handles_[i + 1] = v;
      throw_if_stopped(stop);
    });
    hint_ = handles_.size() > 1 ? handles_.back() : Handle();
  }

  Insertion insert(const Point& p, bool local, InsertMode mode, std::vector<Vertex>& around) override {
    around.clear();
    const auto q = Traits::to_cgal(p);
    if (t_.dimension() < d) return insert_flat(q, local, around);
    zone_.clear();
    if (const Handle old = Traits::conflicts(t_, q, hint_cell(), zone_); old != Handle()) return {old->info(), false};
    collect_zone_vertices(around);
    if (mode == InsertMode::if_local_neighbour) {
      bool touches_local = false;
      for (const Vertex v : around) touches_local |= local_[v] != 0;
      if (!touches_local) {
        // The next point is probably near, so the next walk begins here.
        hint_ = handles_[around.front()];
        return {0, false};
      }
    }
    Traits::make_room(t_);
    return {label(Traits::insert_into(t_, q, zone_), local), true};
  }

  void remove(Vertex v) override {
    assert(alive(v));
    t_.remove(handles_[v]);
    handles_[v] = Handle();
    hint_ = Handle();
  }

  void star(Vertex v, std::vector<Vertex>& cells) const override {
    cells.clear();
    Traits::for_each_incident_cell(t_, handles_[v], [&](Cell c) {
      for (int i = 0; i <= d; ++i) cells.push_back(c->vertex(i)->info());
    });
  }

  void neighbours(Vertex v, std::vector<Vertex>& around) const override {
    around.clear();
    Traits::for_each_neighbour(t_, handles_[v], [&](Handle w) { around.push_back(w->info()); });
  }

  void edges_from(Vertex first, const std::function<void(Vertex, Vertex)>& visit) const override {
    for (Vertex v = first; v < handles_.size(); ++v) {
      if (alive(v)) Traits::for_each_neighbour(t_, handles_[v], [&](Handle w) { visit(v, w->info()); });
    }
  }

  CellList cells() const override {
    CellList list;
    std::uint32_t n = 0;
    Traits::for_each_cell(t_, [&](Cell c) { c->number = n++; });
    list.vertices.resize(std::size_t{n} * (d + 1));
    list.neighbors.resize(std::size_t{n} * (d + 1));
    Vertex* vertex = list.vertices.data();
    std::uint32_t* neighbor = list.neighbors.data();
    Traits::for_each_cell(t_, [&](Cell c) {
      for (int i = 0; i <= d; ++i) {
        *vertex++ = c->vertex(i)->info();
        *neighbor++ = c->neighbor(i)->number;
      }
    });
    return list;
  }

  CellRecords take_cells() override {
    CellRecords rows;
    std::uint32_t n = 0;
    Traits::for_each_cell(t_, [&](Cell c) { c->number = n++; });
    if (n > CellRecord::most) throw KernelFull();
    rows.resize(n);
    Traits::for_each_cell(t_, [&](Cell c) {
      CellRecord& row = rows[c->number];
      for (int i = 0; i <= d; ++i) {
        const Cell across = c->neighbor(i);
        row.vertices[i] = c->vertex(i)->info();
        row.neighbors[i] = 4 * across->number + static_cast<std::uint32_t>(across->index(c));
      }
    });
    return rows;
  }

  std::vector<Vertex> explore(const std::function<bool(const Vertex*)>& is_final, CellList* all,
                              std::vector<std::uint8_t>* open) override {
    enum : std::uint8_t { unseen, marked_open, marked_final };
    std::vector<Cell> seen;  // open and final cells, to be unmarked at the end
    std::vector<Vertex> found;
    std::array<Vertex, d + 1> corner;
    const auto visit = [&](Cell c) {
      if (c->mark != unseen) return;
      bool all_local = true;
      for (int i = 0; i <= d; ++i) {
        corner[i] = c->vertex(i)->info();
        all_local &= local_[corner[i]] != 0;
      }
      c->mark = all_local && is_final(corner.data()) ? marked_final : marked_open;
      seen.push_back(c);
      if (c->mark == marked_open) found.insert(found.end(), corner.begin(), corner.end());
    };
    for (Vertex v = 0; v < handles_.size(); ++v) {
      if (!local_[v] && alive(v)) Traits::for_each_incident_cell(t_, handles_[v], visit);
    }
    for (std::size_t next = 0; next < seen.size(); ++next) {
      const Cell c = seen[next];
      if (c->mark != marked_open) continue;
      for (int i = 0; i <= d; ++i) visit(c->neighbor(i));
    }
    if (all) {
      *all = cells();
      open->clear();
      Traits::for_each_cell(t_, [&](Cell c) { open->push_back(c->mark == marked_open); });
    }
    for (const Cell c : seen) c->mark = unseen;
    return found;
  }

  bool can_freeze() const override { return false; }
  FinalCells freeze(const std::function<bool(const Vertex*)>&) override {
    check(false, "this kernel cannot freeze cells");
    return {};
  }
  std::uint64_t discard(const std::function<bool(const Vertex*)>&, const TakeVertices&) override {
    check(false, "this kernel cannot discard cells");
    return 0;
  }

  std::unique_ptr<Kernel> clone() const override {
    auto copy = std::make_unique<CgalKernel>();
    check(copy->load(save()), "a kernel loads what it saved");
    return copy;
  }
  std::uint32_t rows() const override { return 0; }
  CellRecord row(std::uint32_t) const override {
    check(false, "this kernel has no rows");
    return {};
  }

  KernelImage save() const override {
    KernelImage image;
    const Vertex n = vertices();
    image.dimension = dimension();
    image.points.resize(n);
    image.local.assign(local_.begin() + 1, local_.end());
    image.alive.resize(n);
    for (Vertex v = 1; v <= n; ++v) {
      if (!alive(v)) continue;
      image.points[v - 1] = point(v);
      image.alive[v - 1] = 1;
    }
    if (dimension() == d) image.cells = cells();
    return image;
  }

  bool load(const KernelImage& image) override {
    if (!valid(image)) return false;
    reset();
    const std::size_t n = image.points.size();
    local_.resize(n + 1);
    handles_.resize(n + 1);
    std::copy(image.local.begin(), image.local.end(), local_.begin() + 1);
    if (image.dimension < d) {  // a flat image has few points, so they are inserted again
      for (std::size_t i = 0; i < n; ++i) {
        if (!image.alive[i]) continue;
        const Handle v = t_.insert(Traits::to_cgal(image.points[i]));
        v->info() = static_cast<Vertex>(i + 1);
        handles_[i + 1] = v;
      }
      return true;
    }
    auto& tds = t_.tds();
    tds.clear();
    tds.set_dimension(d);
    for (std::size_t i = 0; i <= n; ++i) {
      if (i > 0 && !image.alive[i - 1]) continue;
      const Handle v = tds.create_vertex();
      v->info() = static_cast<Vertex>(i);
      if (i > 0) v->set_point(Traits::to_cgal(image.points[i - 1]));
      handles_[i] = v;
    }
    t_.set_infinite_vertex(handles_[0]);
    const std::size_t m = image.cells.vertices.size() / (d + 1);
    std::vector<Cell> made(m);
    for (std::size_t c = 0; c < m; ++c) {
      std::array<Handle, d + 1> corner;
      for (int i = 0; i <= d; ++i) corner[i] = handles_[image.cells.vertices[c * (d + 1) + i]];
      made[c] = Traits::create_cell(tds, corner);
      for (const Handle v : corner) Traits::set_cell_of(v, made[c]);
    }
    for (std::size_t c = 0; c < m; ++c) {
      std::array<Cell, d + 1> next;
      for (int i = 0; i <= d; ++i) next[i] = made[image.cells.neighbors[c * (d + 1) + i]];
      Traits::set_neighbours(made[c], next);
    }
    return true;
  }

  std::size_t memory() const override {
    return Traits::memory(t_) + handles_.capacity() * sizeof(Handle) + local_.capacity();
  }

 private:
  void reset() {
    t_.clear();
    t_.infinite_vertex()->info() = infinite_vertex;
    handles_.assign(1, t_.infinite_vertex());
    local_.assign(1, 0);
    hint_ = Handle();
  }

  Cell hint_cell() const { return hint_ == Handle() ? Cell() : Traits::cell_of(hint_); }

  Vertex label(Handle v, bool local) {
    v->info() = static_cast<Vertex>(handles_.size());
    handles_.push_back(v);
    local_.push_back(local);
    hint_ = v;
    return v->info();
  }

  // While all points are collinear or coplanar, CGAL does not break ties by the perturbation. So every vertex counts as
  // a neighbour of every other vertex.
  template <class CgalPoint>
  Insertion insert_flat(const CgalPoint& q, bool local, std::vector<Vertex>& around) {
    const std::size_t before = t_.number_of_vertices();
    const Handle v = t_.insert(q);
    if (t_.number_of_vertices() == before) return {v->info(), false};
    for (Vertex w = 1; w <= vertices(); ++w) {
      if (alive(w)) around.push_back(w);
    }
    return {label(v, local), true};
  }

  // Every vertex of a conflict zone lies on the zone's boundary. So these vertices are the neighbours of the inserted
  // point.
  void collect_zone_vertices(std::vector<Vertex>& around) {
    mark_.resize(handles_.size(), 0);
    for (const Cell c : zone_.cells) {
      for (int i = 0; i <= d; ++i) {
        const Vertex v = c->vertex(i)->info();
        if (v == infinite_vertex || mark_[v]) continue;
        mark_[v] = 1;
        around.push_back(v);
      }
    }
    for (const Vertex v : around) mark_[v] = 0;
  }

  static bool valid(const KernelImage& image) {
    const std::size_t n = image.points.size(), corners = image.cells.vertices.size();
    if (image.local.size() != n || image.alive.size() != n) return false;
    if (image.cells.neighbors.size() != corners || corners % (d + 1) != 0) return false;
    if (image.frozen != 0) return false;
    if (image.dimension < -1 || image.dimension > d || (image.dimension < d) != (corners == 0)) return false;
    for (const Vertex v : image.cells.vertices) {
      if (v > n || (v > 0 && !image.alive[v - 1])) return false;
    }
    for (const std::uint32_t c : image.cells.neighbors) {
      if (c >= corners / (d + 1)) return false;
    }
    return true;
  }

  Triangulation t_;
  std::vector<Handle> handles_;      // by vertex number; [0] is the infinite vertex; null = removed
  std::vector<std::uint8_t> local_;  // by vertex number: the label
  std::vector<std::uint8_t> mark_;   // scratch; all 0 between calls
  typename Traits::Zone zone_;       // scratch
  Handle hint_;                      // the vertex at which the next walk begins
};

}  // namespace tessera
