// Which files a user means: patterns, folders, lists.
#include "src/input/cloud/inputs.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "src/base/option.h"
#include "tests/input/io_testing.h"

namespace tessera::testing_io {
namespace {

class Inputs : public testing::Test {
 protected:
  void file(const std::string& name, const std::string& text = "1 2 3\n") const {
    std::filesystem::create_directories((folder_.path() / name).parent_path());
    folder_.write(name, text);
  }
  std::string at(const std::string& name) const { return (folder_.path() / name).string(); }

  Result<std::vector<InputName>> find(InputQuestion question) const {
    Spool spool(folder_.path());
    return find_inputs(question, spool);
  }
  // Names below the folder, one a line, or the sentence of the error.
  std::string names(InputQuestion question) const {
    const auto found = find(std::move(question));
    if (found.has_error()) return in_plain_words(found.error().where);
    std::string lines;
    for (const auto& input : found.value())
      lines += std::filesystem::path(input.path).lexically_relative(folder_.path()).string() + "\n";
    return lines;
  }

  TempFolder folder_;
};

TEST_F(Inputs, OfAFolderAreItsPointFilesByBytes) {
  for (const char* name : {"b.LAS", "a10.xyz.gz", "a2.ply", "c.csv.zst", "d.laz", "e.npy", "read.me", "image.tif",
                           "x.gz", ".a.las", "._d.laz", "sub/z.las"})
    file("block/" + std::string(name));
  EXPECT_EQ(names({.patterns = {at("block")}}),
            "block/a10.xyz.gz\nblock/a2.ply\nblock/b.LAS\nblock/c.csv.zst\nblock/d.laz\nblock/e.npy\n");
  EXPECT_EQ(names({.patterns = {at("block/")}}), names({.patterns = {at("block")}}));
  EXPECT_EQ(names({.patterns = {at("blo?k")}}), names({.patterns = {at("block")}}));
}

TEST_F(Inputs, OfAFolderIncludeItsSubfoldersWhenAskedFor) {
  for (const char* name : {"b.las", "a/z.las", "a/deep/y.las", ".hidden/x.las", "out/mesh.ply", "out/manifest.json",
                           "out/triangulation.pvtu"})
    file("block/" + std::string(name));
  std::filesystem::create_directory_symlink(at("block"), at("block/a/round"));
  EXPECT_EQ(names({.patterns = {at("block")}}), "block/b.las\n");
  EXPECT_EQ(names({.patterns = {at("block")}, .recursive = true}), "block/a/deep/y.las\nblock/a/z.las\nblock/b.las\n");
}

TEST_F(Inputs, OfAFolderWithoutPointFilesAreAnError) {
  file("block/sub/a.las");
  file("block/read.me");
  file("out/.run/plan.json");
  EXPECT_EQ(
      names({.patterns = {at("block")}}),
      at("block") +
          ": holds no point files (.las, .laz, .ply, .off, .obj, .stl, .npy, "
          ".pcd, .e57, .ptx, .xyz, .csv, .tsv, .txt, .asc, .pts, .gadget, .hdf5, .h5, .tipsy, .fits, .fit, .dat, these "
          "with .gz or .zst, and ept.json); recursive=true looks into its subfolders, too");
  EXPECT_EQ(find({.patterns = {at("block")}}).error().code, Errc::io);
  EXPECT_EQ(names({.patterns = {at("out")}}),
            at("out") + ": is a result folder, and holds no input; exporting it makes point files");
}

TEST_F(Inputs, OfAFolderThatAreNoPointsSayHowToLeaveThemOut) {
  const auto input = InputName{.path = "x.txt", .before = "list, line 2: ", .behind = " (why)"};
  EXPECT_EQ(input.explained(error(Errc::bad_input, "x.txt: is empty")).where, "list, line 2: x.txt: is empty (why)");
  file("block/read.txt");
  EXPECT_EQ(find({.patterns = {at("block")}}).value()[0].behind, " (it was found in the folder " + at("block") +
                                                                     "; to leave it out, name the others, as in '" +
                                                                     at("block/*.las") + "')");
}

TEST_F(Inputs, OfAListBeginAtItsFolderAndFollowThoseGiven) {
  for (const char* name : {"1.las", "lists/2.las", "lists/3.las", "lists/sub/4.las", "5.las", "lists/with blank.las"})
    file(name);
  file("lists/list.txt",
       "\xEF\xBB\xBF# comment\r\n\n  3.las\t\r\n   \nsub\n../5.las\n" + at("1.las") + "\n[23].las\nwith blank.las");
  EXPECT_EQ(
      names({.patterns = {at("5.las")}, .list = at("lists/list.txt")}),
      "5.las\nlists/3.las\nlists/sub/4.las\nlists/../5.las\n1.las\nlists/2.las\nlists/3.las\nlists/with blank.las\n");
  EXPECT_EQ(find({.list = at("lists/list.txt")}).value()[1].before, at("lists/list.txt") + ", line 5: ");
}

TEST_F(Inputs, OfAListThatAreWrongAreNamedByListAndLine) {
  file("list.txt", "# none\n\n*.laz\n");
  EXPECT_EQ(names({.list = at("list.txt")}),
            at("list.txt") + ", line 3: " + at("*.laz") + ": no file matches this pattern");
  file("list.txt", "# none\n");
  EXPECT_EQ(names({.list = at("list.txt")}), at("list.txt") + ": names no input file");
  file("list.txt", std::string("a\0b\n", 4));
  EXPECT_EQ(names({.list = at("list.txt")}), at("list.txt") + ", line 1: is no file name: it holds a zero byte");
  EXPECT_EQ(names({.list = at("missing.txt")}), at("missing.txt") + ": cannot be opened: No such file or directory");
}

TEST_F(Inputs, AreStandardInputOnceAtMost) {
  EXPECT_TRUE(find({.patterns = {"-"}}).value()[0].standard_input);
  EXPECT_EQ(names({.patterns = {"-", "-"}}), "standard input ('-') can be read once only");
  EXPECT_EQ(names({.patterns = {"-"}, .list = "-"}), "standard input ('-') can be read once only");
  EXPECT_EQ(find({}).error().code, Errc::usage);
}

}  // namespace
}  // namespace tessera::testing_io
