// Damage in a run folder is told, never believed: a wrong point would make a wrong triangulation of it.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <numeric>
#include <optional>
#include <random>

#include "src/base/option.h"
#include "src/tiling/plan.h"
#include "tests/tiling/run_fixture.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

// Points with two attributes, of 5 bytes a row.
class Damage : public RunFixture {
 protected:
  void SetUp() override {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> coordinate(0, 1);
    std::string ply =
        "ply\nformat binary_little_endian 1.0\nelement vertex 600\nproperty double x\nproperty double y\n"
        "property double z\nproperty float intensity\nproperty uchar class\nend_header\n";
    const auto add = [&](const auto& value) { ply.append(reinterpret_cast<const char*>(&value), sizeof value); };
    for (int i = 0; i < 600; ++i) {
      for (int axis = 0; axis < 3; ++axis) add(coordinate(random));
      add(static_cast<float>(i));
      add(static_cast<unsigned char>(i % 11));
    }
    write_text(folder_ / "in.ply", ply);
    auto options = in_dimension(3);
    options.attributes = {"intensity", "class"};
    const auto run =
        route(open_cloud((folder_ / "in.ply").string(), options), run_folder(), {.tiles = 3}, progress_, {});
    ASSERT_TRUE(run) << run.error().where;
    ASSERT_EQ(row_bytes(run.value().schema), 5u);
    ASSERT_TRUE(use()) << "what is whole is refused";
  }

  // As a resumed run does: in a new process, which has checked nothing yet.
  Status use() const {
    BOOST_OUTCOME_TRY(run, open_run(run_folder()));
    for (std::uint32_t t = 0; t < run.partition.tiles(); ++t) {
      BOOST_OUTCOME_TRY(tile, load_tile(run, TileId{t}));
      BOOST_OUTCOME_TRYV(load_rows(run, TileId{t}, {tile.ids.front()}));
    }
    return success();
  }

  fs::path folder_of(const char* kind) const { return run_folder() / kind; }
  fs::path bundle(const char* kind) const { return folder_of(kind) / "000000-000000.bin"; }
};

TEST_F(Damage, OfAnyBitInAnyFileIsToldWithTheFileAndTheWayOut) {
  std::vector<fs::path> files{run_folder() / "plan.json", run_folder() / "segments.bin"};
  for (const char* kind : {"points", "attributes"}) {
    for (const auto& file : fs::directory_iterator(folder_of(kind))) files.push_back(file.path());
  }
  ASSERT_EQ(files.size(), 4u);
  for (const auto& file : files) {
    const std::string whole = read_text(file);
    for (std::size_t bit = 0; bit < 8 * whole.size(); bit += 8 * whole.size() / 100 + 1) {
      auto damaged = whole;
      damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << bit % 8));
      write_text(file, damaged);
      const auto status = use();
      ASSERT_FALSE(status) << file << ", bit " << bit;
      EXPECT_EQ(status.error().code, Errc::corrupt);
      EXPECT_EQ(status.error().where.find(file.string() + ": "), 0u) << status.error().where;
      EXPECT_NE(in_plain_words(status.error().where).find("overwrite=true starts again"), std::string::npos)
          << status.error().where;
    }
    write_text(file, whole);
  }
  EXPECT_TRUE(use());
}

TEST_F(Damage, OfTwoRecordsOrTwoRowsThatChangedPlacesIsTold) {
  for (const auto& [file, record] : {std::pair{bundle("points"), 32}, std::pair{bundle("attributes"), 5}}) {
    const std::string whole = read_text(file);
    auto damaged = whole;
    std::swap_ranges(damaged.begin(), damaged.begin() + record, damaged.begin() + 10 * record);
    ASSERT_NE(damaged, whole);
    write_text(file, damaged);
    const auto status = use();
    ASSERT_FALSE(status) << file;
    EXPECT_EQ(status.error().code, Errc::corrupt);
    write_text(file, whole);
  }
}

// Only the rows of a few points are wanted, and the damage is elsewhere.
TEST_F(Damage, OfRowsIsToldAtTheFirstCallWhateverItAsksFor) {
  auto damaged = read_text(bundle("attributes"));
  damaged.back() = static_cast<char>(damaged.back() ^ 1);
  write_text(bundle("attributes"), damaged);
  const auto run = open_run(run_folder()).value();
  const auto id = read_points(run, 2).front().id;
  EXPECT_EQ(load_rows(run, TileId{2}, {id}).error().code, Errc::corrupt);
  EXPECT_EQ(load_rows(run, TileId{2}, {id}).error().code, Errc::corrupt) << "found once, believed later";
}

TEST_F(Damage, OfPointsIsToldAlsoWhereOnlyRowsAreWanted) {
  auto damaged = read_text(bundle("points"));
  damaged[damaged.size() - 9] = static_cast<char>(damaged[damaged.size() - 9] ^ 1);
  const auto run = open_run(run_folder()).value();
  const auto id = read_points(run, 2).front().id;
  write_text(bundle("points"), damaged);
  EXPECT_EQ(load_rows(run, TileId{2}, {id}).error().code, Errc::corrupt);
}

}  // namespace
}  // namespace tessera
