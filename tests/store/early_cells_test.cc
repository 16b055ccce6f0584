#include "src/result/store/early_cells.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <span>

#include "src/base/files/checksum.h"
#include "src/base/files/whole_file.h"
#include "tests/store/sample_result.h"

namespace tessera::test {
namespace {

namespace fs = std::filesystem;

// Cells of a mesh from one on to another.
class Part final : public CellStream {
 public:
  Part(const TileMesh& mesh, std::size_t first, std::size_t end) : mesh_(mesh), first_(first), end_(end) {}
  Status vertices(const Consumer& take) const override { return give(mesh_.cells, take); }
  Status neighbors(const Consumer& take) const override { return give(mesh_.neighbors, take); }

 private:
  Status give(std::span<const std::int32_t> numbers, const Consumer& take) const {
    const auto corners = static_cast<std::size_t>(mesh_.dimension) + 1;
    for (std::size_t at = first_; at < end_; at += 1000) {
      BOOST_OUTCOME_TRYV(take(numbers.subspan(at * corners, std::min<std::size_t>(1000, end_ - at) * corners)));
    }
    return success();
  }
  const TileMesh& mesh_;
  std::size_t first_, end_;
};

// Its first half is more than a piece of a checksum.
const TileMesh& sample(int dimension) {
  const auto make = [&](std::size_t n) {
    return sample_tiles(sample_points(Shape::uniform, dimension, n), dimension, 2)[0];
  };
  if (dimension == 2) {
    static const TileMesh in_2d = make(200'000);
    return in_2d;
  }
  static const TileMesh in_3d = make(45'000);
  return in_3d;
}

class EarlyCellsTest : public testing::TestWithParam<int> {
 protected:
  EarlyCellsTest()
      : mesh_(sample(GetParam())),
        cells_(mesh_.cell_ghost.size()),
        early_(cells_ / 2 / early_unit(GetParam()) * early_unit(GetParam())) {}

  Result<EarlyCells> begin(const fs::path& out, std::uint64_t room, const StoreOptions& options = {}) const {
    const Part part(mesh_, 0, early_);
    return write_early_cells(
        out, tile_, {.dimension = GetParam(), .ids = mesh_.ids, .cells = part, .count = early_, .room = room}, options);
  }
  Result<TileEntry> end(const fs::path& out, const EarlyCells& early, const StoreOptions& options = {}) const {
    return write_tile(out, tile_, mesh_, Part(mesh_, early_, cells_), {}, options, &early);
  }
  void expect_mesh(const fs::path& out, bool neighbors = true) const {
    const auto read = read_tile(out, tile_);
    ASSERT_TRUE(read) << read.error().where;
    EXPECT_EQ(read.value().mesh.points, mesh_.points);
    EXPECT_EQ(read.value().mesh.cells, mesh_.cells);
    EXPECT_EQ(read.value().mesh.cell_ghost, mesh_.cell_ghost);
    if (neighbors) {
      EXPECT_EQ(read.value().mesh.neighbors, mesh_.neighbors);
    }
  }

  const TileId tile_{0};
  const TileMesh& mesh_;
  const std::uint64_t cells_, early_;
};

TEST_P(EarlyCellsTest, AreThereWhenTheOthersAreWritten) {
  const TemporaryFolder whole;
  const auto at_once = write_tile(whole.path(), tile_, mesh_, {}, {});
  ASSERT_TRUE(at_once);
  ASSERT_GT(early_ * 4 * (static_cast<std::uint64_t>(GetParam()) + 1), sum_piece_bytes) << "less than a piece";
  for (const std::uint64_t room : {cells_, cells_ + 1, 2 * cells_}) {
    const TemporaryFolder folder;
    const auto early = begin(folder.path(), room);
    ASSERT_TRUE(early) << early.error().where;
    EXPECT_FALSE(fs::exists(tile_file(folder.path(), tile_)));
    const auto entry = end(folder.path(), early.value());
    ASSERT_TRUE(entry) << entry.error().where;
    const auto file = tile_file(folder.path(), tile_);
    EXPECT_EQ(entry.value().digest, at_once.value().digest);
    EXPECT_EQ(entry.value().main_cells, at_once.value().main_cells);
    EXPECT_EQ(entry.value().bytes, fs::file_size(file));
    EXPECT_EQ(entry.value().xxh3, checksum_file(file, ChecksumOf::pieces).value());
    EXPECT_EQ(stored_tiles(folder.path()).value(), std::vector{entry.value()});
    EXPECT_FALSE(fs::exists(early_file(folder.path(), tile_, {})));
    expect_mesh(folder.path());
  }
}

TEST_P(EarlyCellsTest, MoveWhenThereIsTooLittleRoomForTheOthers) {
  const TemporaryFolder right, small;
  const auto entry = end(right.path(), begin(right.path(), cells_).value());
  ASSERT_TRUE(entry);
  for (const std::uint64_t room : {early_, cells_ - 1}) {
    const auto moved = end(small.path(), begin(small.path(), room).value());
    ASSERT_TRUE(moved) << moved.error().where;
    EXPECT_EQ(moved.value(), entry.value());
    EXPECT_EQ(read_whole(tile_file(small.path(), tile_)).value(), read_whole(tile_file(right.path(), tile_)).value());
    expect_mesh(small.path());
  }
}

TEST_P(EarlyCellsTest, GoWithoutNeighborsToo) {
  const TemporaryFolder folder;
  const StoreOptions options{.neighbors = false};
  for (const std::uint64_t room : {early_, cells_}) {
    ASSERT_TRUE(end(folder.path(), begin(folder.path(), room, options).value(), options));
    expect_mesh(folder.path(), false);
  }
}

TEST_P(EarlyCellsTest, AreTakenOverByAnotherNodeAndGiveTheSameFile) {
  const TemporaryFolder one, two;
  const auto entry = end(one.path(), begin(one.path(), cells_).value());
  const StoreOptions first{.node = NodeId{7}}, second{.node = NodeId{8}};
  auto early = begin(two.path(), cells_, first).value();
  ASSERT_TRUE(take_early_cells(two.path(), tile_, early, second));
  EXPECT_FALSE(fs::exists(early_file(two.path(), tile_, NodeId{7})));
  EXPECT_TRUE(fs::exists(early_file(two.path(), tile_, NodeId{8})));
  EXPECT_TRUE(is_temporary_name(early_file(two.path(), tile_, NodeId{8}).filename()));
  EXPECT_EQ(end(two.path(), early, second).value(), entry.value());
  EXPECT_EQ(read_whole(tile_file(one.path(), tile_)).value(), read_whole(tile_file(two.path(), tile_)).value());
}

TEST_P(EarlyCellsTest, AreNotTakenOverWhenTheyAreDamaged) {
  const TemporaryFolder folder;
  const auto early = begin(folder.path(), cells_).value();
  const auto file = early_file(folder.path(), tile_, {});
  const auto good = read_whole(file).value();
  const auto refused = [&](const std::vector<std::byte>& bytes) {
    EXPECT_TRUE(write_whole(file, bytes));
    EarlyCells taken = early;
    const auto status = take_early_cells(folder.path(), tile_, taken, {});
    return !status && status.error().code == Errc::corrupt;
  };
  for (const std::size_t at : {std::size_t{0}, good.size() / 2, good.size() - 1}) {
    auto bad = good;
    bad[at] ^= std::byte{4};
    EXPECT_TRUE(refused(bad)) << at;
  }
  EXPECT_TRUE(refused({good.begin(), good.end() - 4096}));
  EXPECT_TRUE(refused({}));
  EXPECT_FALSE(refused(good));
  fs::resize_file(file, 5000);
  EXPECT_FALSE(end(folder.path(), early)) << "a tile whose first cells are cut off";
  EXPECT_FALSE(fs::exists(tile_file(folder.path(), tile_)));
  fs::remove(file);
  EarlyCells taken = early;
  EXPECT_FALSE(take_early_cells(folder.path(), tile_, taken, {}));
  EXPECT_FALSE(end(folder.path(), early)) << "a tile whose first cells are gone";
}

INSTANTIATE_TEST_SUITE_P(Dimensions, EarlyCellsTest, testing::Values(2, 3));

}  // namespace
}  // namespace tessera::test
