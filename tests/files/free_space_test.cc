#include "src/base/files/free_space.h"

#include "tests/files/files_testing.h"

namespace tessera {
namespace {

class FreeSpace : public FolderFixture {};

TEST_F(FreeSpace, IsToldWhereThereIsAFileSystemThatKnowsItsSize) {
  EXPECT_GT(known_free_bytes(folder()).value_or(0), 0u);
  EXPECT_GT(free_bytes(folder()), 0u);
  EXPECT_EQ(known_free_bytes(folder() / "none"), std::nullopt);
  EXPECT_EQ(known_free_bytes("/proc"), std::nullopt) << "it has no size";
  EXPECT_EQ(free_bytes("/proc"), 0u);
}

TEST_F(FreeSpace, ThatIsTooLittleIsToldWithBothFigures) {
  constexpr std::uint64_t mib = 1 << 20;
  EXPECT_TRUE(check_room("out", "a thing", 5 * mib, 5 * mib));
  EXPECT_TRUE(check_room("out", "a thing", 5 * mib, std::nullopt)) << "nobody can tell";
  const auto refused = check_room("out", "a thing", 5 * mib, 5 * mib - 1);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Errc::io);
  EXPECT_EQ(refused.error().where, "out: a thing needs up to 6 MiB, and the disk has 4 MiB left");
  EXPECT_FALSE(check_room("out", "a thing", 1, 0));
}

}  // namespace
}  // namespace tessera
