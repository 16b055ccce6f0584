// Triangulation::export_to(); what the formats hold is tested in tests/export.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

#include "tests/api/api_testing.h"
#include "tests/api/temporary_home.h"

namespace tessera {
namespace {

using testing::cloud;
using testing::failure_of;
using testing::TemporaryHome;

Triangulation sample(int dimension) {
  TriangulationOptions options;
  options.dimension(dimension);
  options.max_points_per_tile(100);
  return triangulate(cloud("uniform", dimension, 400), options);
}

TEST(ExportTo, WritesEveryCellOnce) {
  const TemporaryHome home;
  const auto t = sample(2);
  const auto target = home.path() / "mesh.off";
  double part = 0;
  EXPECT_EQ(t.export_to(target, ExportRequest().progress([&](double now) { part = now; })), "");
  EXPECT_EQ(part, 1);
  std::ifstream file(target);
  std::string magic, comment;
  std::uint64_t vertices = 0, cells = 0;
  std::getline(file, magic);
  std::getline(file, comment);
  file >> vertices >> cells;
  EXPECT_TRUE(comment.starts_with("# ")) << comment;
  EXPECT_EQ(magic, "OFF");
  EXPECT_EQ(vertices, t.vertices());
  EXPECT_EQ(cells, t.cells());
}

TEST(FileChecksum, IsThatOfTheManifest) {
  const auto t = sample(2);
  std::ifstream file(t.folder() / "manifest.json");
  const std::string manifest(std::istreambuf_iterator<char>(file), {});
  EXPECT_NE(manifest.find(file_checksum(t.folder() / "triangulation.pvtu")), std::string::npos);
  EXPECT_EQ(failure_of([&] { file_checksum(t.folder() / "missing"); }).cause(), Cause::io);
}

TEST(ExportTo, RefusesInTheWordsOfTheLibrary) {
  const TemporaryHome home;
  const auto t = sample(3);
  const auto target = home.path() / "mesh.ply";
  t.export_to(target);
  const auto taken = failure_of([&] { t.export_to(target); });
  EXPECT_EQ(taken.cause(), Cause::usage);
  EXPECT_EQ(taken.what(), target.string() + ": exists already; overwrite(true) replaces it");
  t.export_to(target, ExportRequest().overwrite(true));
  EXPECT_EQ(failure_of([&] { t.export_to(home.path() / "mesh.obj"); }).cause(), Cause::usage);
  EXPECT_EQ(failure_of([&] { t.export_to(home.path() / "no" / "mesh.ply"); }).cause(), Cause::io);
}

TEST(ExportTo, LeavesLongCellsOut) {
  const TemporaryHome home;
  const auto t = sample(2);
  const auto target = home.path() / "mesh.off";
  t.export_to(target, ExportRequest().max_edge(0.1));
  std::ifstream file(target);
  std::string magic, comment;
  std::uint64_t vertices = 0, cells = 0;
  std::getline(file, magic);
  std::getline(file, comment);
  file >> vertices >> cells;
  EXPECT_TRUE(comment.starts_with("# ")) << comment;
  EXPECT_LT(cells, t.cells());
  EXPECT_GT(cells, 0u);
  const auto none = home.path() / "none.off";
  EXPECT_NE(std::string(failure_of([&] { t.export_to(none, ExportRequest().max_edge(1e-9)); }).what()).find("max_edge"),
            std::string::npos);
  for (const double wrong : {0.0, -1.0, std::nan(""), HUGE_VAL})
    EXPECT_EQ(failure_of([&] { t.export_to(none, ExportRequest().max_edge(wrong)); }).what(),
              std::string("max_edge: must be a length, finite and above 0"));
  EXPECT_FALSE(std::filesystem::exists(none));
  EXPECT_EQ(failure_of([&] { t.export_to(none, ExportRequest().max_radius(-1)); }).what(),
            std::string("max_radius: must be a length, finite and above 0"));
}

TEST(ExportTo, AnExceptionOfTheCallbackComesOutAndLeavesNothing) {
  const TemporaryHome home;
  const auto t = sample(3);
  const auto before = home.entries();
  const auto enough = [](double) { throw std::out_of_range("as it is"); };
  EXPECT_THROW(t.export_to(home.path() / "mesh.ply", ExportRequest().progress(enough)), std::out_of_range);
  EXPECT_EQ(home.entries(), before);
}

}  // namespace
}  // namespace tessera
