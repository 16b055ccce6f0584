#include "src/base/files/private_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "tests/files/files_testing.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

class Private : public FolderFixture {
 protected:
  static void rights(const fs::path& path, unsigned mode) { ASSERT_EQ(::chmod(path.c_str(), mode), 0); }
  static unsigned rights(const fs::path& path) {
    struct stat status {};
    EXPECT_EQ(::stat(path.c_str(), &status), 0);
    return status.st_mode & 0777U;
  }
};

TEST_F(Private, AFileThatOthersCanReadIsRefused) {
  const fs::path file = folder() / "secret";
  ASSERT_TRUE(write_whole(file, std::string_view("text")));
  for (const unsigned mode : {0604U, 0602U, 0601U, 0666U, 0664U}) {
    rights(file, mode);
    for (const Mend mend : {Mend::refused, Mend::allowed}) {
      const auto kept = keep_private(file, mend);
      ASSERT_FALSE(kept) << mode;
      EXPECT_EQ(kept.error().code, Errc::usage);
      EXPECT_EQ(rights(file), mode);
    }
  }
  for (const unsigned mode : {0600U, 0400U}) {
    rights(file, mode);
    EXPECT_FALSE(keep_private(file, Mend::allowed).value());
    EXPECT_EQ(rights(file), mode);
  }
  EXPECT_EQ(keep_private(folder() / "none", Mend::allowed).error().code, Errc::io);
}

TEST_F(Private, RightsOfTheGroupAloneAreTakenAwayWhereThatIsAllowed) {
  const fs::path file = folder() / "secret";
  ASSERT_TRUE(write_whole(file, std::string_view("text")));
  for (const unsigned mode : {0660U, 0640U, 0610U}) {
    rights(file, mode);
    EXPECT_FALSE(keep_private(file, Mend::refused));
    EXPECT_TRUE(keep_private(file, Mend::allowed).value());
    EXPECT_EQ(rights(file), 0600U);
  }
}

TEST_F(Private, AFolderIsMadeForThisUserAlone) {
  ASSERT_TRUE(make_private_folder(folder() / "above" / "scratch"));
  EXPECT_EQ(rights(folder() / "above" / "scratch"), 0700U);
  ASSERT_TRUE(make_private_folder(folder() / "above" / "scratch/")) << "once more, and with a slash";
  rights(folder() / "above" / "scratch", 0770);
  ASSERT_TRUE(make_private_folder(folder() / "above" / "scratch"));
  EXPECT_EQ(rights(folder() / "above" / "scratch"), 0700U);
}

TEST_F(Private, AFolderOfOthersIsRefused) {
  const fs::path scratch = folder() / "scratch";
  fs::create_directory(scratch);
  for (const unsigned mode : {0777U, 0702U}) {
    rights(scratch, mode);
    EXPECT_EQ(make_private_folder(scratch).error().code, Errc::usage) << mode;
    EXPECT_EQ(rights(scratch), mode);
  }
  rights(scratch, 0700);
  const fs::path link = folder() / "link";
  fs::create_directory_symlink(scratch, link);
  EXPECT_TRUE(make_private_folder(link)) << "of our own";
  ASSERT_TRUE(write_whole(folder() / "file", std::string_view("text")));
  EXPECT_FALSE(make_private_folder(folder() / "file"));
  if (::geteuid() != 0) return;  // nothing can be given to another user
  ASSERT_EQ(::lchown(link.c_str(), 65534, 65534), 0);
  EXPECT_EQ(make_private_folder(link).error().code, Errc::usage);
  ASSERT_EQ(::chown(scratch.c_str(), 65534, 65534), 0);
  EXPECT_EQ(make_private_folder(scratch).error().code, Errc::usage);
}

}  // namespace
}  // namespace tessera
