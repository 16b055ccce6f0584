// Polygons of any shape: what they take, and that they are what their rings say.
#include "src/result/query/area.h"

#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <random>
#include <vector>

#include "src/base/ledger.h"

namespace tessera::query {
namespace {

std::uint64_t allocated() {
  const auto info = ::mallinfo2();
  return info.uordblks + info.hblkhd;
}

// Each edge as high as all of it.
std::vector<Point> comb(int n) {
  std::vector<Point> ring;
  for (int i = 0; i < n; ++i) ring.push_back({static_cast<double>(i % 10), static_cast<double>(i % 2), 0});
  return ring;
}

std::string geojson(const std::vector<Point>& ring) {
  std::string text = R"({"type":"Polygon","coordinates":[[)";
  for (const Point& p : ring)
    text += (text.back() == '[' ? "[" : ",[") + std::to_string(p.x) + "," + std::to_string(p.y) + "]";
  return text + "]]}";
}

TEST(PolygonTest, TakesAFixedNumberOfBytesForAVertexWhateverItLooksLike) {
  constexpr int n = 20'000;
  std::vector<std::vector<Point>> rings{comb(n)};
  const auto before = allocated() - n * sizeof(Point);
  const Polygon polygon(std::move(rings));
  EXPECT_LE(allocated() - before, n * Polygon::bytes_of_edge);
}

TEST(PolygonTest, DrawsItsMemoryBeforeItTakesIt) {
  constexpr std::uint64_t room = 1000 * Polygon::bytes_of_edge;
  Ledger ledger({.memory = {room, "the memory of a question"}});
  const Ledger::Use use(&ledger);
  EXPECT_TRUE(Polygon::of_geojson(geojson(comb(1000)), "the body"));
  const auto refused = Polygon::of_geojson(geojson(comb(1000)), "the body");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Errc::memory);
  EXPECT_NE(refused.error().where.find("the memory of a question"), std::string::npos);
}

// The same with small whole numbers, edge by edge.
struct Plain {
  std::vector<std::vector<Point>> rings;

  static std::int64_t side(const Point& a, const Point& b, const Point& c) {
    const auto whole = [](double x) { return static_cast<std::int64_t>(x); };
    return (whole(b.x) - whole(a.x)) * (whole(c.y) - whole(a.y)) -
           (whole(b.y) - whole(a.y)) * (whole(c.x) - whole(a.x));
  }
  static bool on(const Point& p, const Point& a, const Point& b) {
    return side(a, b, p) == 0 && std::min(a.x, b.x) <= p.x && p.x <= std::max(a.x, b.x) && std::min(a.y, b.y) <= p.y &&
           p.y <= std::max(a.y, b.y);
  }
  static bool cross(const Point& a, const Point& b, const Point& c, const Point& d) {
    const auto sign = [](std::int64_t x) { return (x > 0) - (x < 0); };
    return (sign(side(a, b, c)) * sign(side(a, b, d)) < 0 && sign(side(c, d, a)) * sign(side(c, d, b)) < 0) ||
           on(c, a, b) || on(d, a, b) || on(a, c, d) || on(b, c, d);
  }
  template <class Visit>
  void each_edge(const Visit& visit) const {
    for (const auto& ring : rings)
      for (std::size_t i = 0; i < ring.size(); ++i) visit(ring[i], ring[(i + 1) % ring.size()]);
  }
  bool contains(const Point& p) const {
    bool inside = false, border = false;
    each_edge([&](Point a, Point b) {
      border = border || on(p, a, b);
      if (a.y > b.y) std::swap(a, b);
      if (a.y <= p.y && p.y < b.y && side(a, b, p) > 0) inside = !inside;
    });
    return inside || border;
  }
  bool meets(const std::array<Point, 3>& cell) const {
    bool met = contains(cell[0]);
    each_edge([&](const Point& a, const Point& b) {
      for (std::size_t k = 0; k < 3; ++k) met = met || cross(a, b, cell[k], cell[(k + 1) % 3]);
      met = met || (side(cell[0], cell[1], a) > 0 && side(cell[1], cell[2], a) > 0 && side(cell[2], cell[0], a) > 0);
    });
    return met;
  }
};

TEST(PolygonTest, IsWhatItsRingsSayWithLowAndHighEdges) {
  std::mt19937 random(7);
  const auto to = [&](int most) { return static_cast<double>(random() % static_cast<unsigned>(most)); };
  for (int round = 0; round < 30; ++round) {
    Plain plain;
    // Of many low edges and some that pass all strips.
    std::vector<Point> ring;
    for (int i = 0; i < 40 + round * 10; ++i) ring.push_back({to(1000), i % 9 < round % 9 ? to(1000) : to(4) + i, 0});
    plain.rings = {ring, comb(11)};
    const Polygon polygon(plain.rings);
    int met = 0;
    for (int i = 0; i < 300; ++i) {
      const double x = to(1000), y = to(1000);
      const std::array<Point, 3> cell{Point{x, y, 0}, Point{x + 1 + to(30), y + to(5), 0}, Point{x, y + 6 + to(30), 0}};
      EXPECT_EQ(polygon.meets(cell), plain.meets(cell)) << round << ": " << x << ", " << y;
      met += polygon.meets(cell) ? 1 : 0;
    }
    EXPECT_GT(met, 0);
    EXPECT_LT(met, 300);
  }
}

}  // namespace
}  // namespace tessera::query
