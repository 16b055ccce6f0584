#include "tests/tile/periodic.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <random>

#include "src/base/check.h"
#include "src/geometry/predicates/independent/predicates.h"
#include "src/tiling/tile/rebuild.h"
#include "tests/tile/setting.h"

namespace tessera::testing {
namespace {

// Its points span the axes without a period; the images of the first span the others.
std::vector<std::size_t> spanning(const PeriodicCloud& cloud, std::size_t first) {
  std::vector<int> axes;
  for (int axis = 0; axis < cloud.dimension; ++axis) {
    if (cloud.period.length[static_cast<std::size_t>(axis)] == 0) axes.push_back(axis);
  }
  const auto flat = [&](std::size_t i) {
    Point p;
    for (std::size_t k = 0; k < axes.size(); ++k) p[static_cast<int>(k)] = cloud.points[i].at[axes[k]];
    return p;
  };
  std::vector<std::size_t> chosen{first};
  for (std::size_t i = 0; i < cloud.points.size() && chosen.size() < axes.size() + 1; ++i) {
    const bool independent =
        chosen.size() == 1 ? flat(i) != flat(chosen[0])
        : chosen.size() == 2
            ? independent::orientation_2(flat(chosen[0]), flat(chosen[1]), flat(i)) != 0
            : independent::orientation_3(flat(chosen[0]), flat(chosen[1]), flat(chosen[2]), flat(i)) != 0;
    if (independent) chosen.push_back(i);
  }
  return chosen;
}

struct Mail {
  std::uint32_t from, to;
  std::vector<SharedPoint> points;
};

class Tiles {
 public:
  Tiles(const PeriodicCloud& cloud, const PeriodicOptions& options)
      : cloud_(cloud), options_(options), rng_(options.seed) {
    const Assignment a = assign(options.how, cloud.points, options.tiles, options.seed);
    tiles_.resize(*std::max_element(a.tile_of.begin(), a.tile_of.end()) + 1);
    for (std::size_t i = 0; i < cloud.points.size(); ++i) {
      tiles_[a.tile_of[i]].points.push_back(cloud.points[i].at);
      tiles_[a.tile_of[i]].ids.push_back(cloud.points[i].id);
    }
    std::vector<Bounds> bounds;
    for (std::size_t i = 0; i < tiles_.size(); ++i) {
      tiles_[i].box = a.boxes.empty() ? Box{{1, 1, 1}, {-1, -1, -1}} : a.boxes[i];
      for (int axis = 0; axis < 3; ++axis) {
        const double length = cloud.period.length[static_cast<std::size_t>(axis)];
        if (length == 0) continue;
        tiles_[i].box.lo[axis] = std::max(tiles_[i].box.lo[axis], 0.0);
        tiles_[i].box.hi[axis] = std::min(tiles_[i].box.hi[axis], length);
      }
      bounds.emplace_back();
      for (const Point& p : tiles_[i].points) bounds.back().add(p);
    }
    around_ = KnownFromStart(bounds, neighbours(bounds), seeds(a), cloud.period);
  }

  std::vector<TileMesh> run() {
    std::vector<std::uint32_t> waiting;
    for (std::uint32_t i = 0; i < tiles_.size(); ++i) {
      if (!tiles_[i].points.empty()) waiting.push_back(i);
    }
    std::shuffle(waiting.begin(), waiting.end(), rng_);
    while (!waiting.empty() || !mail_.empty() || introduce_late()) {
      const std::size_t choice = rng_() % (mail_.size() + waiting.size());
      if (choice >= mail_.size()) {
        start(waiting.back());
        waiting.pop_back();
        continue;
      }
      std::swap(mail_[choice], mail_.back());
      if (!tiles_[mail_.back().to].t) continue;  // it keeps its mail until it has triangulated
      const Mail m = std::move(mail_.back());
      mail_.pop_back();
      deliver(m);
    }
    std::vector<TileMesh> meshes;
    for (std::uint32_t i = 0; i < tiles_.size(); ++i) {
      if (!tiles_[i].points.empty()) meshes.push_back(mesh_of(i));
    }
    return meshes;
  }

 private:
  struct Tile {
    std::vector<Point> points;
    std::vector<PointId> ids;
    Box box;
    PendingFinals finals;
    std::uint64_t counted = 0;
    std::unique_ptr<TileTriangulation> t;
  };

  std::vector<std::vector<TileId>> neighbours(const std::vector<Bounds>& bounds) const {
    std::vector<std::vector<TileId>> out(tiles_.size());
    for (std::uint32_t i = 0; i < tiles_.size() && options_.announce; ++i) {
      for (std::uint32_t k = 0; k < tiles_.size(); ++k) {
        for (const PeriodOffset& o : cloud_.period.offsets()) {
          const TileId other = image_of(TileId{k}, o);
          if (other != TileId{i} && !bounds[k].empty()) out[i].push_back(other);
        }
      }
      std::sort(out[i].begin(), out[i].end());
    }
    return out;
  }

  std::vector<Seed> seeds(const Assignment& a) {
    std::vector<Seed> out;
    for (const std::size_t i : spanning(cloud_, rng_() % cloud_.points.size())) {
      out.push_back({{cloud_.points[i].at, cloud_.points[i].id, TileId{a.tile_of[i]}, 0},
                     std::numeric_limits<double>::infinity()});
    }
    if (options_.random_seeds) add_random_seeds(cloud_.points, a.tile_of, rng_, out);
    return out;
  }

  void post(std::uint32_t from) {
    for (auto& [to, list] : tiles_[from].t->take_updates()) mail_.push_back({from, to.value, std::move(list)});
  }

  TileOptions tile_options(std::uint32_t i) const {
    return {TileId{i}, cloud_.dimension, options_.kernel, ExchangeRule::introduce, &around_};
  }

  void start(std::uint32_t i) {
    Tile& self = tiles_[i];
    self.t = std::make_unique<TileTriangulation>(tile_options(i));
    self.t->triangulate(self.points, self.ids);
    self.finals = {};
    self.counted = 0;
    if (options_.reduce && options_.counted) {
      self.counted = self.t->discard(self.points, self.box, rng_() % 2 == 0, [](std::span<const Vertex>) {});
    } else if (options_.reduce) {
      self.finals.cells = self.t->reduce(self.points, self.box);
    }
    if (self.box.lo.x < self.box.hi.x) self.t->announce(self.points, self.box);
    if (rng_() % 2 == 0) self.t->introduce();
    post(i);
  }

  bool introduce_late() {
    for (std::uint32_t i = 0; i < tiles_.size(); ++i) {
      if (tiles_[i].points.empty()) continue;
      tiles_[i].t->introduce();
      post(i);
    }
    return !mail_.empty();
  }

  void deliver(const Mail& m) {
    if (options_.sleep) {
      const auto bytes = tiles_[m.to].t->save();
      tiles_[m.to].t = std::make_unique<TileTriangulation>(tile_options(m.to));
      check(tiles_[m.to].t->load(bytes), "a tile wakes from its image");
    }
    if (options_.reborn && births_ < 3 && rng_() % 4 == 0) bear_again(m.to);
    const Status received = tiles_[m.to].t->receive(TileId{m.from}, m.points);
    check(received.has_value(), "tiles are told of sound points");
    tiles_[m.to].t->introduce();
    post(m.to);
  }

  // A tile begins again from its points, and what was under way to it and from it is lost.
  void bear_again(std::uint32_t i) {
    ++births_;
    std::erase_if(mail_, [&](const Mail& m) { return m.from == i || m.to == i; });
    start(i);
    const std::vector<TileId> reborn{TileId{i}};
    for (std::uint32_t k = 0; k < tiles_.size(); ++k) {
      if (k == i || !tiles_[k].t) continue;
      tiles_[k].t->replay_to(reborn);
      tiles_[k].t->introduce();
      post(k);
    }
  }

  TileMesh mesh_of(std::uint32_t i) {
    Tile& t = tiles_[i];
    if (!options_.counted) return t.t->collect(t.points, t.ids, std::move(t.finals)).whole();
    const RestOfTile rest = t.t->collect_rest([](std::span<const Vertex>) {});
    const std::uint64_t own = t.points.size();
    std::vector<TileId> owners(own, TileId{i});
    for (const SharedPoint& p : rest.foreign) {
      t.points.push_back(p.at);
      t.ids.push_back(p.id);
      owners.push_back(p.tile);
    }
    auto mesh = rebuild({cloud_.dimension, TileId{i}, own, t.points, t.ids, owners});
    check(mesh.has_value(), "what a tile has left can be rebuilt");
    const TileMesh& made = mesh.value();
    const auto main = std::count(made.cell_ghost.begin(), made.cell_ghost.end(), 0);
    check(made.cell_ghost.size() == t.counted + rest.cells, "as many cells as were counted");
    check(static_cast<std::uint64_t>(main) == t.counted + rest.main_cells, "as many main cells as were counted");
    return std::move(mesh).value();
  }

  const PeriodicCloud& cloud_;
  const PeriodicOptions& options_;
  std::mt19937_64 rng_;
  std::vector<Tile> tiles_;
  KnownFromStart around_;
  std::vector<Mail> mail_;
  int births_ = 0;
};

}  // namespace

std::vector<TileMesh> periodic_splay(const PeriodicCloud& cloud, const PeriodicOptions& options) {
  return Tiles(cloud, options).run();
}

}  // namespace tessera::testing
