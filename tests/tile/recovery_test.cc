#include "tests/tile/recovery.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <random>
#include <string>

#include "src/geometry/reference/clouds.h"
#include "src/geometry/reference/reference.h"

namespace tessera::testing {
namespace {

// Tiny: nearly every point has to do with every tile. On a lattice so small that most of it is cospherical; or of the
// kinds that are degenerate in other ways.
std::vector<LocalPoint> tiny_cloud(int dimension, std::mt19937_64& rng) {
  const std::uint64_t points = 4 + rng() % 14;
  if (rng() % 3 == 0) {
    const std::string& kind = cloud_kinds()[rng() % cloud_kinds().size()];
    return make_cloud(kind, dimension, points, rng());
  }
  constexpr std::uint64_t sides[] = {2, 3, 4, 6, 12, 40};
  const std::uint64_t side = sides[rng() % 6], height = rng() % 4 == 0 ? 2 : side;
  std::vector<LocalPoint> cloud;
  for (std::uint64_t i = 0; i < points; ++i) {
    const auto along = [&](std::uint64_t n) { return static_cast<double>(rng() % n); };
    const double x = along(side), y = along(dimension == 3 ? side : height), z = dimension == 3 ? along(height) : 0;
    const Point p{x, y, z};
    const auto equal = [&](const LocalPoint& q) { return q.at == p; };
    if (std::none_of(cloud.begin(), cloud.end(), equal)) cloud.push_back({p, cloud.size()});
  }
  return cloud;
}

// Empty: right. Nothing: the points span no volume.
std::optional<std::string> run(std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  RecoveryOptions options;
  options.seed = seed;
  options.dimension = 2 + static_cast<int>(rng() % 2);
  options.kernel = rng() % 8 == 0 ? KernelKind::cgal : KernelKind::flat;
  options.announced = rng() % 2 == 0 ? Announced::minimum : Announced::spanning;
  options.reduce = rng() % 4 == 0;
  options.random_seeds = rng() % 3 == 0;
  options.announce = rng() % 8 != 0;
  options.mail_bytes_max = rng() % 2 == 0 ? rng() % 4 * sizeof(SharedPoint) : ~std::uint64_t{0};
  options.losses = 1 + static_cast<std::uint32_t>(rng() % 4);
  options.patience = std::uint32_t{2} << rng() % 7;
  options.sleep = rng() % 2 == 0;
  options.prompt = rng() % 2 == 0;
  options.images = rng() % 4 == 0;
  options.settle = rng() % 4 == 0;
  const auto cloud = tiny_cloud(options.dimension, rng);
  const auto expected = global_delaunay(cloud, options.dimension);
  if (expected.empty()) return std::nullopt;
  const std::uint32_t tiles = 2 + static_cast<std::uint32_t>(rng() % 7);
  const Recovered got = recover(cloud, assign(rng() % 4 == 0 ? "stripes" : "random", cloud, tiles, seed), options);
  return got.wrong.empty() ? difference(expected, main_cells(got.meshes)) : got.wrong;
}

std::uint64_t number(const char* name, std::uint64_t otherwise) {
  const char* text = std::getenv(name);
  return text ? std::strtoull(text, nullptr, 10) : otherwise;
}

// Thousands here; docs/design.md says of how many it was right. RECOVERY_SEED is the first, RECOVERY_RUNS how many.
TEST(Recovery, IsRightForAnyPointsAnyTilesAnySeedsAnyOrderAndAnyLosses) {
  const std::uint64_t first = number("RECOVERY_SEED", 0), runs = number("RECOVERY_RUNS", 4000);
  std::uint64_t wrong = 0, done = 0;
  for (std::uint64_t seed = first; seed < first + runs; ++seed) {
    const std::optional<std::string> what = run(seed);
    done += what ? 1 : 0;
    if (!what || what->empty()) continue;
    if (++wrong <= 3) ADD_FAILURE() << "seed " << seed << ": " << *what;
  }
  EXPECT_EQ(wrong, 0u) << "of " << done;
  EXPECT_GT(done, runs * 3 / 4);
}

// Each is wrong when a part of the rule is left out: the refused points (205385, 425444, 1185376, 1443210), that words
// of an older table are not believed (265436, 366057, 1184248), what was relied on (9006, 20389, 21438).
TEST(Recovery, IsRightWhereAWeakerRuleIsWrong) {
  for (const std::uint64_t seed : {205385, 425444, 1185376, 1443210, 265436, 366057, 1184248, 9006, 20389, 21438}) {
    EXPECT_EQ(run(seed), "") << "seed " << seed;
  }
}

}  // namespace
}  // namespace tessera::testing
