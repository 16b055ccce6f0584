#include "src/base/files/folder.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <string>

#include "tests/files/files_testing.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

class Folders : public FolderFixture {
 protected:
  std::set<std::string> names() const {
    std::set<std::string> found;
    FolderReader reader(folder());
    while (const char* name = reader.next()) EXPECT_TRUE(found.insert(name).second);
    EXPECT_FALSE(reader.error());
    EXPECT_EQ(reader.next(), nullptr);
    return found;
  }
  void write(const fs::path& path) const { ASSERT_TRUE(write_whole(path, std::string_view("text"))); }
};

TEST_F(Folders, AreReadNameByNameWhateverStandsInThem) {
  EXPECT_EQ(names(), std::set<std::string>());
  write(folder() / "file");
  write(folder() / ".hidden");
  fs::create_directory(folder() / "folder");
  fs::create_symlink("nothing", folder() / "link");
  EXPECT_EQ(names(), (std::set<std::string>{".hidden", "file", "folder", "link"}));
  FolderReader none(folder() / "none");
  EXPECT_EQ(none.error(), std::errc::no_such_file_or_directory);
  EXPECT_EQ(none.next(), nullptr);
}

TEST_F(Folders, AreRemovedWithAllThatIsInThemAndNothingThatALinkLeadsTo) {
  const auto tree = folder() / "tree";
  fs::create_directories(tree / "a" / "b" / "c");
  for (int i = 0; i < 100; ++i) write(tree / "a" / std::to_string(i));
  write(tree / "a" / "b" / "c" / "deep");
  fs::create_directory(folder() / "kept");
  write(folder() / "kept" / "file");
  fs::create_directory_symlink(folder() / "kept", tree / "link");
  EXPECT_FALSE(remove_tree(tree));
  EXPECT_EQ(names(), std::set<std::string>{"kept"});
  EXPECT_TRUE(fs::exists(folder() / "kept" / "file"));
  write(folder() / "file");
  EXPECT_FALSE(remove_tree(folder() / "file"));
  EXPECT_FALSE(remove_tree(folder() / "none"));
  EXPECT_FALSE(remove_tree(folder() / "none" / "below"));
  EXPECT_EQ(names(), std::set<std::string>{"kept"});
}

TEST_F(Folders, ThatCannotBeRemovedSayWhy) {
  EXPECT_TRUE(remove_tree("/proc/self/fd"));
  const auto refused = remove_whole("/proc/self/fd");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Errc::io);
  EXPECT_TRUE(refused.error().where.starts_with("/proc/self/fd: cannot be removed: ")) << refused.error().where;
}

TEST_F(Folders, AreRemovedWhetherTheyAreThereOrNot) {
  fs::create_directories(folder() / "tree" / "a");
  write(folder() / "tree" / "a" / "file");
  EXPECT_TRUE(remove_whole(folder() / "tree"));
  EXPECT_EQ(names(), std::set<std::string>());
  EXPECT_TRUE(remove_whole(folder() / "tree"));
}

}  // namespace
}  // namespace tessera
