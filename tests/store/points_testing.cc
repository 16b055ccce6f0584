#include "tests/store/points_testing.h"

#include <gtest/gtest.h>

#include "src/base/files/whole_file.h"
#include "src/result/store/points_file.h"
#include "tests/store/sample_result.h"

namespace tessera::test {

std::vector<std::byte> file_with_columns(const PointsTile& tile, std::span<const store::ColumnValues> columns) {
  const TemporaryFolder folder;
  const auto from = folder.path() / "from.pts", to = folder.path() / "to.pts";
  EXPECT_TRUE(write_whole(from, points_file_bytes(view_of(tile))));
  const store::TileCopy copy{.tile = tile.tile, .from = from, .to = to, .final_name = to};
  const auto written = store::copy_points_with_columns(copy, columns, {});
  EXPECT_TRUE(written) << (written ? "" : written.error().where);
  const auto bytes = read_whole(to).value();
  return {bytes.begin(), bytes.end()};
}

}  // namespace tessera::test
