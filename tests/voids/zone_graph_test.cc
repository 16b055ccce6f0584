// The hierarchy of voids against its definition: water that rises over each core by itself.
#include "src/result/voids/zone_graph.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <random>
#include <set>
#include <vector>

namespace tessera::voids {
namespace {

struct Cloud {
  std::vector<Zone> zones;
  std::vector<Saddle> saddles;
};

// Few different levels, so that many saddles are at one vertex. The zones may be in several parts.
Cloud random_cloud(std::mt19937_64& rng) {
  Cloud cloud;
  const auto zones = static_cast<ZoneNumber>(1 + rng() % 30);
  for (ZoneNumber i = 0; i < zones; ++i) {
    Zone zone{.core = {static_cast<double>(rng() % 5), {i}}, .place = {}, .points = 1 + rng() % 9, .volume = {}};
    zone.volume.add(ScaledDouble::of(static_cast<double>(1 + rng() % 100) / 7));
    cloud.zones.push_back(zone);
  }
  const std::uint64_t saddles = rng() % 80, levels = 1 + rng() % 40;
  for (std::uint64_t i = 0; i < saddles && zones > 1; ++i) {
    const auto a = static_cast<ZoneNumber>(rng() % zones), b = static_cast<ZoneNumber>(rng() % zones);
    const std::uint64_t vertex = rng() % levels;
    if (a != b)
      cloud.saddles.push_back(
          {std::min(a, b), std::max(a, b), {10.0 + static_cast<double>(vertex / 3), {100 + vertex}}});
  }
  return cloud;
}

bool is_above(const Level& a, const Level& b) { return b < a; }

// All zones that water reaches from `zone` without rising above `level`; without the saddles at it when it is `below`.
std::set<ZoneNumber> reached(const Cloud& cloud, ZoneNumber zone, const Level& level, bool below) {
  std::set<ZoneNumber> all{zone};
  for (std::size_t before = 0; before != all.size();) {
    before = all.size();
    for (const Saddle& saddle : cloud.saddles) {
      if (is_above(saddle.level, level) || (below && saddle.level == level)) continue;
      if (all.contains(saddle.a)) all.insert(saddle.b);
      if (all.contains(saddle.b)) all.insert(saddle.a);
    }
  }
  return all;
}

void expect_by_definition(const Cloud& cloud, const std::vector<Void>& voids) {
  std::vector<Level> levels;
  for (const Saddle& saddle : cloud.saddles) levels.push_back(saddle.level);
  std::sort(levels.begin(), levels.end());
  const auto deeper = [&](ZoneNumber a, ZoneNumber b) { return cloud.zones[a].core < cloud.zones[b].core; };
  for (ZoneNumber zone = 0; zone < cloud.zones.size(); ++zone) {
    std::optional<Level> out;
    ZoneNumber parent = no_zone;
    std::set<ZoneNumber> flooded = reached(cloud, zone, {1e9, {}}, false);
    for (const Level& level : levels) {
      const auto all = reached(cloud, zone, level, false);
      const ZoneNumber deepest = *std::min_element(all.begin(), all.end(), deeper);
      if (deepest == zone) continue;
      out = level;
      parent = deepest;
      flooded = reached(cloud, zone, level, true);
      break;
    }
    std::uint64_t points = 0;
    OrderFreeSum volume;
    for (const ZoneNumber one : flooded) {
      points += cloud.zones[one].points;
      volume.add(cloud.zones[one].volume);
    }
    EXPECT_EQ(voids[zone].saddle, out);
    EXPECT_EQ(voids[zone].parent, parent);
    EXPECT_EQ(voids[zone].zones, flooded.size());
    EXPECT_EQ(voids[zone].points, points);
    EXPECT_EQ(voids[zone].volume.value().value(), volume.value().value());
  }
}

TEST(ZoneGraph, VoidsAreThoseOfTheDefinition) {
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    std::mt19937_64 rng(seed);
    const Cloud cloud = random_cloud(rng);
    ZoneGraph graph(cloud.zones);
    graph.add(cloud.saddles);
    expect_by_definition(cloud, graph.voids());
    if (HasFailure()) FAIL() << "seed " << seed;
  }
}

TEST(ZoneGraph, KeepsWhatMattersOfManySaddles) {
  std::mt19937_64 rng(1);
  Cloud cloud = random_cloud(rng);
  while (cloud.zones.size() < 25) cloud = random_cloud(rng);
  ZoneGraph graph(cloud.zones);
  graph.add(cloud.saddles);
  const auto n = cloud.zones.size();
  for (int batch = 0; batch < 60; ++batch) {  // more than it holds at once
    std::vector<Saddle> saddles;
    for (int i = 0; i < 5000; ++i) {
      const auto a = static_cast<ZoneNumber>(rng() % (n - 1)), b = static_cast<ZoneNumber>(a + 1 + rng() % (n - 1 - a));
      saddles.push_back({a, b, {static_cast<double>(10 + rng() % 100'000), {100 + rng() % 50}}});
    }
    graph.add(saddles);
    std::sort(saddles.begin(), saddles.end(), [](const auto& x, const auto& y) { return x.level < y.level; });
    saddles.resize(200);  // the lowest are all that the slow definition needs
    cloud.saddles.insert(cloud.saddles.end(), saddles.begin(), saddles.end());
  }
  std::sort(cloud.saddles.begin(), cloud.saddles.end(), [](const auto& x, const auto& y) { return x.level < y.level; });
  cloud.saddles.resize(400);
  expect_by_definition(cloud, graph.voids());
}

TEST(ZoneGraph, FindsZonesByTheirCores) {
  ZoneGraph graph({{.core = {1, {7}}, .place = {}, .points = 1, .volume = {}},
                   {.core = {2, {3}}, .place = {}, .points = 1, .volume = {}}});
  EXPECT_EQ(graph.find({3}), 0u);
  EXPECT_EQ(graph.find({7}), 1u);
  EXPECT_EQ(graph.find({5}), no_zone);
}

TEST(ZoneGraph, ProbabilitiesAreThoseOfZobov) {
  EXPECT_EQ(void_probability(1, 2), 1);
  EXPECT_EQ(void_probability(1, 3), 1);
  EXPECT_NEAR(void_probability(2, 2), 0.0742735782, 1e-9);
  EXPECT_NEAR(void_probability(2, 3), 0.0026851, 1e-6);  // exp(-5.92)
}

}  // namespace
}  // namespace tessera::voids
