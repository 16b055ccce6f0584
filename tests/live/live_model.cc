#include "tests/live/live_model.h"

#include <algorithm>
#include <cstring>
#include <random>
#include <set>

#include "src/base/mixed_bits.h"
#include "src/geometry/predicates/exact/predicates.h"
#include "src/geometry/reference/clouds.h"
#include "tests/update/stored_cloud.h"

namespace tessera::testing {

LiveModel::LiveModel(const LiveCase& c, std::size_t count, std::uint64_t seed) : case_(c), seed_(seed) {
  for (const LocalPoint& p : make_cloud(c.kind, c.dimension, count, seed)) pool_.push_back(p.at);
  Bounds bounds;
  for (const Point& p : pool_) bounds.add(p);
  partition_ = Partition::build_tiles(c.partition, c.dimension, pool_, bounds, c.tiles);
  for (const Point& p : pool_) {
    if (next_id_ < pool_.size() * 2 / 3) points_[PointId{next_id_++}] = p;
  }
}

void LiveModel::store(const std::filesystem::path& out) const { store(out, partition_); }

Manifest LiveModel::store(const std::filesystem::path& out, const Partition& partition) const {
  StoredCloud cloud;
  cloud.dimension = case_.dimension;
  cloud.partition = partition;
  cloud.points = list();
  cloud.points_read = next_id_;
  if (case_.attributes) cloud.schema = some_schema();
  cloud.duplicate_rows = !case_.old_software;
  cloud.kind_of = [this](TileId) { return case_.store; };
  return cloud.store(out);
}

std::vector<LocalPoint> LiveModel::list() const {
  std::vector<LocalPoint> out;
  for (const auto& [id, p] : points_) out.push_back({p, id});
  return out;
}

std::vector<IdCell> LiveModel::cells() const { return global_delaunay(list(), case_.dimension); }

// Where the attributes of duplicates are not kept, no vertex goes whose duplicate stays, which is refused.
ResultChange LiveModel::next() const {
  std::mt19937_64 rng(finalised_bits(seed_ * 1000003 + version_));
  ResultChange out;
  std::vector<PointId> ids;
  for (const auto& [id, p] : points_) ids.push_back(id);
  const std::uint64_t way = rng() % 4;
  std::set<Point> gone;
  if (way != 0 && !ids.empty()) {
    const std::uint64_t most = way == 3 ? ids.size() / 2 : 1 + rng() % 5;
    const Point center = points_.at(ids[rng() % ids.size()]);
    std::sort(ids.begin(), ids.end(), [&](PointId a, PointId b) {
      const Point &p = points_.at(a), &q = points_.at(b);
      const auto far = [&](const Point& x) {
        return (x.x - center.x) * (x.x - center.x) + (x.y - center.y) * (x.y - center.y) +
               (x.z - center.z) * (x.z - center.z);
      };
      return std::pair(far(p), a) < std::pair(far(q), b);
    });
    if (way == 1) std::shuffle(ids.begin(), ids.end(), rng);
    for (std::size_t k = 0; k < std::min<std::size_t>(most, ids.size()); ++k) {
      out.remove.push_back(ids[k]);
      gone.insert(points_.at(ids[k]));
    }
  }
  if (case_.old_software) {
    out.remove.clear();
    for (const auto& [id, p] : points_) {
      if (gone.contains(p)) out.remove.push_back(id);
    }
  }
  std::shuffle(out.remove.begin(), out.remove.end(), rng);
  if (way != 1) {
    const std::uint64_t count = 1 + rng() % (case_.grows ? 40 : points_.size() < pool_.size() ? 12 : 3);
    for (std::uint64_t k = 0; k < count; ++k) {
      Point p = pool_[rng() % pool_.size()];
      if (case_.grows) p.x += static_cast<double>(rng() % 8) / 8;
      if (case_.grows) p.y += static_cast<double>(rng() % 8) / 8;
      if (rng() % 16 == 0) p.x = p.x * 50 + 3;  // outside
      out.add.push_back(p);
    }
  }
  if (case_.attributes) {
    std::vector<PointId> added;
    for (std::size_t i = 0; i < out.add.size(); ++i) added.push_back(PointId{next_id_ + i});
    out.rows = some_rows(added);
  }
  return out;
}

void LiveModel::apply(const ResultChange& change) {
  for (const PointId id : change.remove) points_.erase(id);
  for (const Point& p : change.add) points_[PointId{next_id_++}] = p;
  ++version_;
}

bool LiveModel::go_on() {
  const ResultChange change = next();
  const bool allowed = allows(change);
  if (allowed) {
    apply(change);
  } else {
    skip();
  }
  return allowed;
}

bool LiveModel::allows(const ResultChange& change) const {
  LiveModel after = *this;
  after.apply(change);
  return !after.cells().empty();
}

std::string LiveModel::compare(const LiveVersion& version) const {
  const std::vector<IdCell> expected = cells();
  std::set<PointId> vertices;
  std::set<IdCell> got;
  for (const IdCell& cell : expected) vertices.insert(cell.begin(), cell.begin() + case_.dimension + 1);
  if (version.vertices() != vertices.size())
    return std::to_string(version.vertices()) + " vertices, not " + std::to_string(vertices.size());
  for (const auto& [id, p] : points_) {
    const auto star = version.star(id);
    if (star.has_value() != vertices.contains(id)) return "point " + to_string(id) + " is a vertex, or is not";
    if (!star) continue;
    if (version.point(id) != p) return "point " + to_string(id) + " is elsewhere";
    for (const LiveCell& cell : *star) {
      IdCell sorted = cell.ids;
      std::sort(sorted.begin(), sorted.end());
      if (std::count(sorted.begin(), sorted.end(), LiveCell::infinite) == 3 - case_.dimension) got.insert(sorted);
    }
    // Every cell around the vertex must be in its star.
    const auto around = std::count_if(expected.begin(), expected.end(), [&, id = id](const IdCell& cell) {
      return std::find(cell.begin(), cell.end(), id) != cell.end();
    });
    const auto finite = std::count_if(star->begin(), star->end(), [&](const LiveCell& cell) {
      return std::count(cell.ids.begin(), cell.ids.end(), LiveCell::infinite) == 3 - case_.dimension;
    });
    if (around != finite) return "the star of point " + to_string(id) + " is another";
  }
  const std::string what = difference(expected, {got.begin(), got.end()});
  return what.empty() ? compare_places(version, expected) : what;
}

std::string LiveModel::compare_places(const LiveVersion& version, const std::vector<IdCell>& expected) const {
  std::mt19937_64 rng(version_);
  const auto contains = [&](const IdCell& cell, const Point& p) {
    std::array<Point, 4> at;
    for (int i = 0; i <= case_.dimension; ++i) at[i] = points_.at(cell[i]);
    const auto sign = [&] {
      return case_.dimension == 3 ? exact::orientation_3(at[0], at[1], at[2], at[3])
                                  : exact::orientation_2(at[0], at[1], at[2]);
    };
    const int whole = sign();
    for (int i = 0; i <= case_.dimension; ++i) {
      const Point corner = std::exchange(at[i], p);
      if (sign() == -whole) return false;
      at[i] = corner;
    }
    return true;
  };
  for (int k = 0; k < 20; ++k) {
    const Point a = pool_[rng() % pool_.size()], b = pool_[rng() % pool_.size()];
    const double t = k % 4 == 0 ? 0 : static_cast<double>(rng() % 1000) / 500;  // also a vertex, or far outside
    const Point p = without_negative_zero({a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.z + t * (b.z - a.z)});
    const auto found = version.locate(p);
    if (!found) {
      if (std::any_of(expected.begin(), expected.end(), [&](const IdCell& cell) { return contains(cell, p); }))
        return "a point inside is said to be outside";
      continue;
    }
    IdCell sorted = found->ids;
    std::sort(sorted.begin(), sorted.end());
    if (!std::binary_search(expected.begin(), expected.end(), sorted)) return "a point is said to be in no cell";
    if (!contains(sorted, p)) return "a point is said to be in a cell that does not contain it";
  }
  return "";
}

}  // namespace tessera::testing
