#include "src/base/files/inside.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "src/base/files/temporary.h"

namespace tessera {
namespace {

TEST(Inside, IsWhatLiesInTheFolderAndNothingElse) {
  const auto temporary = TemporaryFolder::make().value();
  const auto data = temporary.path() / "data";
  std::filesystem::create_directories(data / "results");
  std::filesystem::create_directories(temporary.path() / "database");
  std::filesystem::create_symlink(temporary.path() / "database", data / "out");
  std::filesystem::create_symlink(data, temporary.path() / "link");
  for (const auto& path :
       {data / "results", data / "results/not/there", data / "results/../jobs", temporary.path() / "link/results"}) {
    EXPECT_TRUE(check_inside(data, path)) << path;
    EXPECT_TRUE(check_inside(temporary.path() / "link", path)) << path;
  }
  for (const auto& path :
       {data, data / ".", data / "..", data / "results/../../x", temporary.path() / "database", data / "out/x",
        std::filesystem::path("/etc/passwd"), std::filesystem::path("x"), std::filesystem::path()}) {
    const auto inside = check_inside(data, path);
    ASSERT_FALSE(inside) << path;
    EXPECT_NE(inside.error().where.find("lies outside"), std::string::npos) << inside.error().where;
  }
}

}  // namespace
}  // namespace tessera
