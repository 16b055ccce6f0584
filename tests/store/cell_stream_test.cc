#include "src/geometry/mesh/cell_stream.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <span>

#include "src/base/files/whole_file.h"
#include "src/result/store/tile_store.h"
#include "tests/store/sample_result.h"

namespace tessera::test {
namespace {

namespace fs = std::filesystem;

// The cells of a mesh in pieces of so many rows; `more` rows more of each than there are, or fewer.
class Pieces final : public CellStream {
 public:
  Pieces(const TileMesh& mesh, std::size_t rows, std::ptrdiff_t more = 0) : mesh_(mesh), rows_(rows), more_(more) {}
  Status vertices(const Consumer& take) const override { return give(mesh_.cells, take); }
  Status neighbors(const Consumer& take) const override { return give(mesh_.neighbors, take); }

 private:
  Status give(std::span<const std::int32_t> numbers, const Consumer& take) const {
    const auto corners = static_cast<std::size_t>(mesh_.dimension) + 1;
    const std::size_t first = more_ < 0 ? static_cast<std::size_t>(-more_) * corners : 0;
    for (std::size_t at = first; at < numbers.size(); at += rows_ * corners) {
      BOOST_OUTCOME_TRYV(take(numbers.subspan(at, std::min(rows_ * corners, numbers.size() - at))));
    }
    return more_ > 0 ? take(numbers.first(static_cast<std::size_t>(more_) * corners)) : Status(success());
  }

  const TileMesh& mesh_;
  std::size_t rows_;
  std::ptrdiff_t more_;
};

TileMesh sample(int dimension) { return sample_tiles(sample_points(Shape::uniform, dimension, 3000), dimension, 2)[1]; }

class Stream : public testing::TestWithParam<int> {};

TEST_P(Stream, OfPiecesOfAnySizeIsTheSameFile) {
  const TemporaryFolder whole;
  const TileMesh mesh = sample(GetParam());
  const auto entry = write_tile(whole.path(), TileId{0}, mesh, {}, {});
  ASSERT_TRUE(entry) << entry.error().where;
  TileMesh frame = mesh;
  frame.cells = {};
  frame.neighbors = {};
  for (const std::size_t rows : {1u, 7u, 1024u, 1u << 20}) {
    const TemporaryFolder folder;
    const auto streamed = write_tile(folder.path(), TileId{0}, frame, Pieces(mesh, rows), {}, {});
    ASSERT_TRUE(streamed) << streamed.error().where;
    EXPECT_EQ(streamed.value(), entry.value()) << rows;
    EXPECT_EQ(read_whole(tile_file(folder.path(), TileId{0})).value(),
              read_whole(tile_file(whole.path(), TileId{0})).value());
  }
}

TEST_P(Stream, OfMoreOrFewerCellsThanFlagsIsAnErrorAndLeavesNothing) {
  const TileMesh mesh = sample(GetParam());
  for (const std::ptrdiff_t more : {-1, 1, 100}) {
    const TemporaryFolder folder;
    const auto entry = write_tile(folder.path(), TileId{0}, mesh, Pieces(mesh, 64, more), {}, {});
    ASSERT_FALSE(entry) << more;
    EXPECT_EQ(entry.error().code, Errc::internal);
    EXPECT_TRUE(fs::is_empty(tile_file(folder.path(), TileId{0}).parent_path())) << more;
  }
}

TEST_P(Stream, OfAMeshWhoseArraysDoNotFitIsAnError) {
  TileMesh mesh = sample(GetParam());
  mesh.cells.push_back(0);
  const TemporaryFolder folder;
  const auto entry = write_tile(folder.path(), TileId{0}, mesh, {}, {});
  ASSERT_FALSE(entry);
  EXPECT_EQ(entry.error().code, Errc::internal);
}

INSTANTIATE_TEST_SUITE_P(Dimensions, Stream, testing::Values(2, 3));

}  // namespace
}  // namespace tessera::test
