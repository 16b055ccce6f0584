#include "src/result/voids/zone_graph.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "src/base/disjoint_sets.h"

namespace tessera::voids {
namespace {

bool is_before(const Saddle& x, const Saddle& y) {
  if (x.level != y.level) return x.level < y.level;
  return std::pair(x.a, x.b) < std::pair(y.a, y.b);
}

// Parts that grow together: the state of the flood.
class Flood {
 public:
  explicit Flood(const std::vector<Zone>& zones)
      : zones_(zones), parts_(zones.size()), deepest_(zones.size()), voids_(zones.size()) {
    std::iota(deepest_.begin(), deepest_.end(), ZoneNumber{0});
    for (std::size_t i = 0; i < zones.size(); ++i) {
      voids_[i].points = zones[i].points;
      voids_[i].volume = zones[i].volume;
    }
  }

  // Joins what saddles of one level join.
  void join(std::span<const Saddle> saddles) {
    std::vector<ZoneNumber> joining;  // the deepest zones of the parts that join something
    for (const Saddle& saddle : saddles) {
      for (const ZoneNumber zone : {saddle.a, saddle.b}) joining.push_back(deepest_[parts_.find(zone)]);
    }
    std::sort(joining.begin(), joining.end());
    joining.erase(std::unique(joining.begin(), joining.end()), joining.end());
    for (const Saddle& saddle : saddles) {
      const std::uint32_t a = parts_.find(saddle.a), b = parts_.find(saddle.b);
      if (a == b) continue;
      const ZoneNumber lower = zones_[deepest_[a]].core < zones_[deepest_[b]].core ? deepest_[a] : deepest_[b];
      deepest_[parts_.join(a, b)] = lower;
    }
    for (const ZoneNumber zone : joining) {
      const ZoneNumber parent = deepest_[parts_.find(zone)];
      if (parent == zone) continue;
      voids_[zone].saddle = saddles.front().level;
      voids_[zone].parent = parent;
    }
    // Only now, because a void has what its part had before this level.
    for (const ZoneNumber zone : joining) {
      Void& lost = voids_[zone];
      if (!lost.saddle) continue;
      Void& parent = voids_[lost.parent];
      parent.zones += lost.zones;
      parent.points += lost.points;
      parent.volume.add(lost.volume);
    }
  }

  std::vector<Void> take() { return std::move(voids_); }

 private:
  const std::vector<Zone>& zones_;
  DisjointSets parts_;
  std::vector<ZoneNumber> deepest_;  // by root of a part: the zone with its deepest core
  std::vector<Void> voids_;
};

}  // namespace

ZoneGraph::ZoneGraph(std::vector<Zone> zones) : zones_(std::move(zones)) {
  std::sort(zones_.begin(), zones_.end(), [](const Zone& x, const Zone& y) { return x.core.vertex < y.core.vertex; });
}

ZoneNumber ZoneGraph::find(PointId core) const {
  const auto found = std::lower_bound(zones_.begin(), zones_.end(), core,
                                      [](const Zone& zone, PointId id) { return zone.core.vertex < id; });
  if (found == zones_.end() || found->core.vertex != core) return no_zone;
  return static_cast<ZoneNumber>(found - zones_.begin());
}

void ZoneGraph::add(std::span<const Saddle> saddles) {
  saddles_.insert(saddles_.end(), saddles.begin(), saddles.end());
  if (saddles_.size() > 2 * kept_ + 2 * zones_.size() + (std::size_t{1} << 16)) keep_forest();
}

// A saddle between zones that lower saddles connect joins nothing, at whatever level.
void ZoneGraph::keep_forest() {
  std::sort(saddles_.begin(), saddles_.end(), is_before);
  DisjointSets parts(zones_.size());
  const auto joins_nothing = [&](const Saddle& saddle) {
    const std::uint32_t a = parts.find(saddle.a), b = parts.find(saddle.b);
    if (a == b) return true;
    parts.join(a, b);
    return false;
  };
  std::size_t kept = 0;
  for (const Saddle& saddle : saddles_) {
    if (!joins_nothing(saddle)) saddles_[kept++] = saddle;
  }
  saddles_.resize(kept);
  kept_ = kept;
}

std::vector<Void> ZoneGraph::voids() {
  keep_forest();
  Flood flood(zones_);
  for (std::size_t begin = 0, end = 0; begin < saddles_.size(); begin = end) {
    while (end < saddles_.size() && saddles_[end].level == saddles_[begin].level) ++end;
    flood.join(std::span(saddles_).subspan(begin, end - begin));
  }
  return flood.take();
}

double void_probability(double contrast, int dimension) {
  const double r = contrast - 1;
  return dimension == 2 ? std::exp(-2.6 * r) : std::exp(-5.12 * r - 0.8 * std::pow(r, 2.8));
}

}  // namespace tessera::voids
