// A copy of a LAZ file on a disk that fails or is full, at any call: a whole copy or none.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "src/base/files/temporary.h"
#include "src/base/files/whole_file.h"
#include "src/input/bytes/byte_source.h"
#include "src/input/las_copy/las_copy.h"
#include "tests/disk/failing_disk.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;

const fs::path original = TESSERA_TEST_DATA "/clouds/laz_perf/extrabytes.laz";

Result<std::uint64_t> copy_with_heights(const fs::path& from, const fs::path& to) {
  BOOST_OUTCOME_TRY(source, open_file(from));
  return copy_las(std::move(source), to, {.dimensions = {{.name = "HeightAboveGround", .description = ""}}},
                  [](std::uint64_t first, std::span<double> values) -> Status {
                    for (auto& value : values) value = static_cast<double>(first++);
                    return success();
                  });
}

TEST(LasCopyDisk, IsWholeOrNotThere) {
  const auto good = TemporaryFolder::make().value();
  ASSERT_TRUE(copy_with_heights(original, good.path() / "good.laz"));
  const auto expected = read_whole(good.path() / "good.laz").value();
  std::vector<int> numbers{ENOSPC};
  numbers.insert(numbers.end(), std::begin(disk_errors), std::end(disk_errors));
  std::uint64_t refused = 0;
  for (const std::uint64_t count : {std::uint64_t{1}, std::uint64_t{1'000'000}}) {
    bool all = false;
    for (std::uint64_t first = 1; !all; ++first) {
      const auto folder = TemporaryFolder::make().value();
      const fs::path from = folder.path() / "from.laz", to = folder.path() / "to.laz";
      fs::copy_file(original, from);
      const int number = numbers[first % numbers.size()];
      SCOPED_TRACE("call " + std::to_string(first) + " fails with " + std::generic_category().message(number));
      fail_below(folder.path(), first, count, number);
      const auto copied = copy_with_heights(from, to);
      all = recover_disk().failed == 0;
      if (copied) {
        ASSERT_EQ(read_whole(to).value(), expected);
        continue;
      }
      ++refused;
      EXPECT_EQ(copied.error().code, Errc::io);
      EXPECT_FALSE(fs::exists(to));
      if (count > 1) continue;  // then not even the removal of the temporary file succeeds
      for (const auto& left : fs::directory_iterator(folder.path())) EXPECT_EQ(left.path(), from);
    }
  }
  EXPECT_GT(refused, 20u);
}

}  // namespace
}  // namespace tessera::testing
