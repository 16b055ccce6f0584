// Whether something is there, asked of a disk that fails.
#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "src/base/files/temporary.h"
#include "src/base/files/there.h"
#include "tests/disk/failing_disk.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;

class There : public ::testing::Test {
 protected:
  There() {
    fs::create_directory(folder() / "folder");
    fs::create_directory(folder() / "empty");
    std::ofstream(folder() / "file") << "12345";
    fs::create_symlink("file", folder() / "link");
    fs::create_symlink("nothing", folder() / "dangling");
    fs::create_symlink("loop", folder() / "loop");
    std::ofstream(folder() / "folder" / "inside") << "1";
  }
  const fs::path& folder() const { return folder_.path(); }

 private:
  const TemporaryFolder folder_ = TemporaryFolder::make().value();
};

TEST_F(There, IsWhatTheSystemSays) {
  EXPECT_TRUE(is_there(folder() / "file").value());
  EXPECT_FALSE(is_there(folder() / "none").value());
  EXPECT_FALSE(is_there(folder() / "file" / "below").value());
  EXPECT_FALSE(is_there(folder() / "dangling").value());
  EXPECT_TRUE(is_there(folder() / "dangling", FollowLinks::no).value());
  EXPECT_TRUE(is_regular(folder() / "link").value());
  EXPECT_FALSE(is_regular(folder() / "link", FollowLinks::no).value());
  EXPECT_FALSE(is_folder(folder() / "file").value());
  EXPECT_TRUE(is_folder(folder() / "folder").value());
  EXPECT_TRUE(is_empty_folder(folder() / "empty").value());
  EXPECT_FALSE(is_empty_folder(folder() / "folder").value());
  EXPECT_EQ(file_bytes(folder() / "link").value(), 5u);
  EXPECT_EQ(bytes_if_there(folder() / "file").value(), 5u);
  EXPECT_EQ(bytes_if_there(folder() / "none").value(), std::nullopt);
  EXPECT_EQ(bytes_if_there(folder() / "folder").value(), std::nullopt);
  EXPECT_NE(file_bytes(folder() / "none").error().where.find("No such file"), std::string::npos);
  EXPECT_EQ(file_bytes(folder() / "folder").error().where, (folder() / "folder").string() + ": is not a regular file");
}

TEST_F(There, WhatCannotBeLookedAtIsNotNothing) {
  EXPECT_EQ(is_there(folder() / "loop").error().where,
            (folder() / "loop").string() + ": cannot be examined: Too many levels of symbolic links");
  EXPECT_TRUE(is_there(folder() / "loop", FollowLinks::no).value());
  EXPECT_EQ(is_there(folder() / std::string(300, 'x')).error().code, Errc::io);
}

TEST_F(There, EachErrorOfTheDiskIsTold) {
  const auto file = folder() / "file", none = folder() / "none";
  const auto asked = [&](const fs::path& path) {
    return std::vector<Status>{
        [&]() -> Status {
          BOOST_OUTCOME_TRYV(is_there(path));
          return success();
        }(),
        [&]() -> Status {
          BOOST_OUTCOME_TRYV(is_there(path, FollowLinks::no));
          return success();
        }(),
        [&]() -> Status {
          BOOST_OUTCOME_TRYV(is_folder(path));
          return success();
        }(),
        [&]() -> Status {
          BOOST_OUTCOME_TRYV(is_regular(path));
          return success();
        }(),
        [&]() -> Status {
          BOOST_OUTCOME_TRYV(is_empty_folder(path));
          return success();
        }(),
        [&]() -> Status {
          BOOST_OUTCOME_TRYV(file_bytes(path));
          return success();
        }(),
        [&]() -> Status {
          BOOST_OUTCOME_TRYV(bytes_if_there(path));
          return success();
        }(),
    };
  };
  for (const int number : disk_errors) {
    for (const auto& path : {file, none}) {
      fail_below(folder(), 1, 1'000, number);
      const auto answers = asked(path);
      recover_disk();
      for (const auto& answer : answers) {
        ASSERT_FALSE(answer);
        EXPECT_EQ(answer.error().code, Errc::io);
        EXPECT_EQ(answer.error().where,
                  path.string() + ": cannot be examined: " + std::generic_category().message(number));
      }
    }
  }
}

}  // namespace
}  // namespace tessera::testing
