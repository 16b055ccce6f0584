#include "src/input/generate/writer.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cmath>
#include <csignal>
#include <limits>

#include "src/base/random.h"
#include "src/input/generate/generate.h"
#include "tests/input/io_testing.h"

namespace tessera::testing_io {
namespace {

std::size_t files_in(const std::filesystem::path& folder) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

TEST(Writer, LosesNothingInPlyNumpyAndText) {
  const TempFolder folder;
  Random random(5);
  std::vector<Point> points;
  for (int i = 0; i < 10000; ++i) {
    Point p;
    for (int axis = 0; axis < 3; ++axis)
      p[axis] = std::ldexp(random.between(-1, 1), static_cast<int>(random.bits() % 600) - 300);
    points.push_back(p);
  }
  points.push_back({std::numeric_limits<double>::denorm_min(), std::numeric_limits<double>::max(), -0.1});
  for (const char* name : {"a.ply", "a.npy", "a.xyz", "a.txt", "a.csv"})
    for (const int dimension : {2, 3}) {
      const auto path = folder.path() / name;
      auto writer = open_writer(path, {.dimension = dimension, .points = points.size()});
      ASSERT_EQ(sentence(writer), "");
      ASSERT_EQ(sentence(writer.value()->write(points, {})), "");
      ASSERT_EQ(sentence(writer.value()->finish()), "");
      auto expected = points;
      if (dimension == 2)
        for (auto& p : expected) p.z = 0;
      const auto read = read_path(path);
      ASSERT_EQ(sentence(read), "") << name;
      EXPECT_EQ(read.value().points, expected) << name;
      EXPECT_EQ(read.value().info.dimension, dimension);
    }
}

TEST(Writer, RoundsToAStepInLasAndReadsBackTheNearestDecimals) {
  const TempFolder folder;
  for (const char* shape : {"uniform", "normal", "sphere", "grid", "terrain"}) {
    const GenerateOptions options{.shape = *shape_named(shape), .points = 100000, .seed = 7};
    ASSERT_EQ(sentence(generate(options, folder.path() / "a.las")), "");
    ASSERT_EQ(sentence(generate(options, folder.path() / "a.npy")), "");
    const auto las = read_path(folder.path() / "a.las"), npy = read_path(folder.path() / "a.npy");
    ASSERT_EQ(las.value().points.size(), npy.value().points.size());
    const bool exact = PointGenerator(options).step() > 0;
    Bounds bounds;
    for (std::size_t i = 0; i < las.value().points.size(); ++i) {
      const auto &a = las.value().points[i], &b = npy.value().points[i];
      bounds.add(a);
      for (int axis = 0; axis < 3; ++axis) {
        if (exact)
          ASSERT_EQ(a[axis], b[axis]) << shape;
        else
          ASSERT_NEAR(a[axis], b[axis], 0.51e-8) << shape;
      }
    }
    EXPECT_NEAR(las.value().info.bounds->lo.x, bounds.lo.x, 1e-8);
    EXPECT_EQ(las.value().info.points, 100000u);
  }
}

TEST(Writer, WritesTheSameBytesForTheSameSeed) {
  const TempFolder folder;
  const GenerateOptions options{.shape = CloudShape::terrain, .points = 1000, .seed = 7};
  const auto content = [&](const std::string& name) {
    EXPECT_EQ(sentence(generate(options, folder.path() / name)), "");
    std::ifstream in(folder.path() / name, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  for (const char* extension : {".las", ".ply", ".npy", ".xyz"})
    EXPECT_EQ(content(std::string("a") + extension), content(std::string("b") + extension));
}

TEST(Writer, RefusesPathsItCannotWrite) {
  const TempFolder folder;
  const GenerateOptions options{.points = 10};
  EXPECT_EQ(generate(options, folder.path() / "a.foo").error().code, Errc::usage);
  EXPECT_EQ(generate(options, folder.path() / "none" / "a.las").error().code, Errc::io);
  std::filesystem::create_directory(folder.path() / "b.las");
  EXPECT_EQ(sentence(generate(options, folder.path() / "b.las")),
            (folder.path() / "b.las").string() + ": cannot be written: it is a directory");
  EXPECT_EQ(generate({.points = 0}, folder.path() / "a.las").error().code, Errc::usage);
  EXPECT_EQ(files_in(folder.path()), 1u);
}

TEST(Writer, LeavesNothingWhenInterrupted) {
  const TempFolder folder;
  folder.write("a.xyz", "1 2 3\n");  // the file of before stays
  const auto stopped = generate({.points = 1000000}, folder.path() / "a.xyz", [](std::uint64_t) { return false; });
  EXPECT_EQ(stopped.error().code, Errc::interrupted);
  EXPECT_EQ(files_in(folder.path()), 1u);
  EXPECT_EQ(read_path(folder.path() / "a.xyz").value().points.size(), 1u);
}

TEST(Writer, LeavesNothingWhenTheSystemTakesNoMoreBytes) {
  const TempFolder folder;
  // A limit on file sizes fails like a full disk: write() says no.
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{.rlim_cur = 100000, .rlim_max = before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  for (const char* name : {"a.las", "a.ply", "a.npy", "a.xyz"}) {
    const auto refused = generate({.points = 100000}, folder.path() / name);
    EXPECT_EQ(refused.error().code, Errc::io);
    EXPECT_EQ(sentence(refused), (folder.path() / name).string() + ": cannot be written: File too large");
  }
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, old_handler);
  EXPECT_EQ(files_in(folder.path()), 0u);
}

TEST(Writer, RefusesPointsThatLasIntegersCannotHold) {
  const TempFolder folder;
  Bounds unit;
  unit.add(Point{0, 0, 0});
  unit.add(Point{1, 1, 1});
  auto writer = open_writer(folder.path() / "a.las", {.points = 1, .bounds = unit});
  const std::vector<Point> far{{0, 1e6, 0}};
  EXPECT_NE(sentence(writer.value()->write(far, {})).find("point 0: y = 1000000"), std::string::npos);
}

}  // namespace
}  // namespace tessera::testing_io
