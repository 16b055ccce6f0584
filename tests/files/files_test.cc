#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "src/base/files/checksum.h"
#include "src/base/files/descriptor.h"
#include "src/base/files/disk_file.h"
#include "src/base/files/frame.h"
#include "src/base/files/mapped_file.h"
#include "src/base/files/names.h"
#include "src/base/files/output_file.h"
#include "tests/files/files_testing.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

class Files : public FolderFixture {};

std::string text_of(const fs::path& path) { return std::string(as_text(read_whole(path).value())); }

TEST_F(Files, AWholeFileReplacesTheOldOneAndLeavesNoTemporaryName) {
  const auto path = folder() / "whole";
  ASSERT_TRUE(write_whole(path, std::string_view("a longer text")));
  ASSERT_TRUE(write_whole(path, std::string_view("short")));
  EXPECT_EQ(text_of(path), "short");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder()), fs::directory_iterator()), 1);
}

TEST_F(Files, APrivateFileIsItsOwnersAloneWhateverWasLeftInItsPlace) {
  const fs::path path = folder() / "key";
  ASSERT_TRUE(write_whole(temporary_name(path), std::string_view("what a process that was killed has left")));
  const auto mask = ::umask(0);
  const Status written = write_private(path, to_bytes("secret"));
  ::umask(mask);
  ASSERT_TRUE(written);
  EXPECT_EQ(fs::status(path).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_EQ(as_text(read_whole(path).value()), "secret");
  EXPECT_FALSE(fs::exists(temporary_name(path)));
}

TEST_F(Files, AForkedChildLeavesItsParentsTemporaryOnesAlone) {
  const auto path = folder() / "file";
  std::optional<TemporaryFile> file(path);
  ASSERT_TRUE(write_whole(path, std::string_view("the parent's")));
  std::optional<TemporaryFolder> below = std::move(TemporaryFolder::make(folder() / "below")).value();
  const pid_t child = ::fork();
  if (child == 0) {
    { const TemporaryFolder moved = std::move(*below); }
    file.reset();
    below.reset();
    ::_exit(0);
  }
  ASSERT_EQ(::waitpid(child, nullptr, 0), child);
  EXPECT_TRUE(fs::exists(path));
  EXPECT_TRUE(fs::exists(folder() / "below"));
  file.reset();
  below.reset();
  EXPECT_TRUE(fs::is_empty(folder()));
}

TEST_F(Files, ErrorsNameTheFileThatWasWantedAndWhatTheSystemSays) {
  const auto path = folder() / "no" / "file";
  EXPECT_EQ(write_whole(path, std::string_view("x")).error().where,
            path.string() + ": cannot create: No such file or directory");
  EXPECT_EQ(read_whole(path).error().where, path.string() + ": cannot open: No such file or directory");
  EXPECT_EQ(read_whole(folder()).error().where, folder().string() + ": is not a regular file");
  EXPECT_EQ(OutputFile::create(path).error().where, path.string() + ": cannot be written: No such file or directory");
}

// Opening a named pipe, or reading a device, could take for ever.
TEST_F(Files, WhatIsNoRegularFileIsRefusedAtOnce) {
  const auto pipe = folder() / "pipe", device = folder() / "device", empty = folder() / "empty";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  fs::create_symlink("/dev/zero", device);
  fs::create_symlink("/dev/null", empty);
  const auto refused = [](const auto& result, const fs::path& path) {
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, Errc::io);
    EXPECT_EQ(result.error().where, path.string() + ": is not a regular file");
  };
  for (const auto& path : {pipe, device, empty}) {
    refused(read_whole(path), path);
    refused(checksum_file(path), path);
    refused(checksum_file(path, ChecksumOf::pieces), path);
    refused(MappedFile::open(path), path);
    refused(DiskFile::open(path, DiskFile::Mode::read), path);
    refused(read_frame(path, ScratchKind::state, {}), path);
    refused(check_regular(path), path);
  }
  refused(DiskFile::open(pipe, DiskFile::Mode::append), pipe);
  refused(append_frame(pipe, ScratchKind::mail, {}, {}), pipe);
  const FileHandle reader(::open(pipe.c_str(), O_RDONLY | O_NONBLOCK));  // also when somebody would read it
  refused(DiskFile::open(pipe, DiskFile::Mode::append), pipe);
  EXPECT_TRUE(DiskFile::open(empty, DiskFile::Mode::append));
}

TEST_F(Files, OfManyThatAreSyncedTheOneThatIsMissingIsNamed) {
  std::vector<fs::path> files;
  for (int i = 0; i < 40; ++i) {
    files.push_back(folder() / std::to_string(i));
    ASSERT_TRUE(write_whole(files.back(), std::string_view("x")));
  }
  EXPECT_TRUE(sync_files(files));
  files[30] = folder() / "nowhere";
  const Status synced = sync_files(files);
  ASSERT_FALSE(synced);
  EXPECT_NE(synced.error().where.find("nowhere"), std::string::npos);
}

TEST_F(Files, ADiskFileIsReadInPiecesAsItWasAppended) {
  const auto path = folder() / "disk";
  for (const char* part : {"abc", "de"}) {
    auto file = DiskFile::open(path, DiskFile::Mode::append).value();
    ASSERT_TRUE(file.write(to_bytes(part)));
    ASSERT_TRUE(file.close());
  }
  auto file = DiskFile::open(path, DiskFile::Mode::read).value();
  EXPECT_EQ(file.size().value(), 5u);
  std::vector<std::byte> piece(3);
  EXPECT_EQ(file.read(piece).value(), 3u);
  EXPECT_EQ(as_text(piece), "abc");
  EXPECT_EQ(file.read(piece).value(), 2u);
  EXPECT_EQ(file.read(piece).value(), 0u);
  EXPECT_EQ(as_text(MappedFile::open(path).value().bytes()), "abcde");
}

TEST_F(Files, AnOutputFileIsThereOnceItIsCommitted) {
  const auto path = folder() / "output";
  {
    auto file = OutputFile::create(path).value();
    ASSERT_TRUE(file.append("abc"));
  }
  EXPECT_TRUE(fs::is_empty(folder()));
  auto file = OutputFile::create(path).value();
  ASSERT_TRUE(file.append("header"));
  ASSERT_TRUE(file.append(std::string(3'000'000, 'x')));
  ASSERT_TRUE(file.overwrite(0, to_bytes("HEAD")));
  ASSERT_TRUE(file.append("end"));
  EXPECT_FALSE(fs::exists(path));
  ASSERT_TRUE(file.commit());
  EXPECT_EQ(text_of(path), "HEADer" + std::string(3'000'000, 'x') + "end");
}

TEST_F(Files, ANamelessFileIsNowhereInItsFolder) {
  auto file = nameless_file(folder()).value();
  ASSERT_TRUE(write_at(file.get(), to_bytes("abc"), 2, folder()));
  std::vector<std::byte> bytes(8);
  EXPECT_EQ(read_up_to(file.get(), bytes, 1, folder()).value(), 4u);
  EXPECT_TRUE(fs::is_empty(folder()));
}

TEST_F(Files, TheSumsOfRecordsAddUpHoweverTheyAreCutAndTellTheirOrder) {
  std::vector<std::uint64_t> records{5, 5, 6, 7};
  const auto bytes = [&] { return std::as_bytes(std::span(records)); };
  const auto sum = record_checksum(bytes(), 8, 10);
  EXPECT_EQ(sum, record_checksum(bytes().first(8), 8, 10) + record_checksum(bytes().subspan(8), 8, 11));
  EXPECT_NE(sum, record_checksum(bytes(), 8, 11));
  std::swap(records[1], records[2]);
  EXPECT_NE(sum, record_checksum(bytes(), 8, 10));
}

TEST_F(Files, ThePathOfAManifestNamesAVersion) {
  for (const fs::path out : {"r", "a/b/r", "/r", ".", ".."}) {
    for (const auto& path : {version_file(out, 42), version_copy(out, 42)}) {
      const auto named = named_version(path);
      ASSERT_TRUE(named) << path;
      EXPECT_EQ(named->out, out);
      EXPECT_EQ(named->version, 42u);
    }
  }
  EXPECT_EQ(named_version(".versions/000007.json")->out, ".");
  for (const char* other : {"r", "", "000007.json", "r/000007.json", "r/.versions/7.json", "r/.versions/000000.json",
                            "r/.versions/log.json", "r/.versions/", "r/.versions/pass/000007.json"})
    EXPECT_FALSE(named_version(other)) << other;
}

TEST_F(Files, ListsOfDuplicatesAreKnownByTheirNames) {
  EXPECT_EQ(duplicates_file("r", 0xabc).string(), "r/duplicates-0000000000000abc.bin");
  for (const char* name : {"duplicates.bin", "r/duplicates-0123456789abcdef.bin"}) {
    EXPECT_TRUE(is_duplicates_name(name)) << name;
    EXPECT_TRUE(is_result_name(fs::path(name).filename())) << name;
  }
  for (const char* name : {"duplicates-.bin", "duplicates-0123456789abcde.bin", "duplicates-0123456789abcdeg.bin",
                           "duplicates-0123456789abcdef.bin.tmp", "duplicates-0123456789ABCDEF.bin", "duplicates"})
    EXPECT_FALSE(is_duplicates_name(name)) << name;
}

TEST_F(Files, NamesInAResultFolderAreToldApart) {
  const TileId tile{42};
  std::set<fs::path> names{manifest_file("r"),
                           master_file("r"),
                           tiles_folder("r"),
                           tile_file("r", tile),
                           done_file("r", NodeId{3}),
                           duplicates_file("r"),
                           duplicates_file("r", 7),
                           version_log_file("r"),
                           duplicate_rows_file("r"),
                           report_file("r"),
                           lock_folder("r"),
                           run_folder("r"),
                           new_run_folder("r"),
                           plan_file("r"),
                           points_folder("r"),
                           attributes_folder("r"),
                           segments_file("r"),
                           points_file("r", {1, 42}),
                           attributes_file("r", {1, 42}),
                           routing_file("r"),
                           routed_splits_folder("r"),
                           routed_split_file("r", 42),
                           settled_file("r", NodeId{3}),
                           settled_marker("r")};
  std::size_t expected = 24;
  for (const auto kind : scratch_kinds) {
    names.insert(scratch_folder("r", kind));
    names.insert(scratch_file("r", kind, tile));
    expected += 2;
  }
  EXPECT_EQ(names.size(), expected);
  EXPECT_EQ(tile_file("r", tile), "r/tiles/000042.vtu");
  EXPECT_EQ(scratch_file("r", ScratchKind::mail, tile), "r/mail/000042.bin");
  EXPECT_TRUE(is_tile_name(temporary_name(tile_file("r", tile))));
  EXPECT_TRUE(is_done_name(done_file("r", NodeId{3})));
  EXPECT_TRUE(is_temporary_name(temporary_name(tile_file("r", tile))));
  EXPECT_TRUE(is_temporary_name(temporary_name_of_process(tile_file("r", tile))));
  EXPECT_TRUE(is_new_run_name(new_run_folder("r")));
  EXPECT_TRUE(is_new_run_name("r/.run.new"));  // of older software
  EXPECT_FALSE(is_new_run_name(run_folder("r")));
  EXPECT_TRUE(is_result_name(temporary_name(manifest_file("r"))));
  EXPECT_TRUE(is_result_name("r/triangulation.vtkhdf"));
  EXPECT_FALSE(is_result_name("r/notes.txt"));
  for (const auto kind : scratch_kinds) EXPECT_TRUE(is_run_name(scratch_folder("r", kind)));
  EXPECT_EQ(stage_folder("r", 0), "r");
  EXPECT_TRUE(is_run_name(stage_folder("r", 1)));
  EXPECT_TRUE(is_run_name(temporary_name(plan_file("r"))));
  EXPECT_FALSE(is_run_name("r/tests.run.xml"));
  EXPECT_FALSE(is_tile_name("r/tiles/mine.vtu"));
  EXPECT_TRUE(is_tile_name(done_file("r", NodeId{3})));
  EXPECT_TRUE(is_tile_name("r/tiles/000042.done"));  // of older software
  EXPECT_FALSE(is_tile_name("r/tiles/node-000003.vtu"));
  EXPECT_TRUE(is_settled_name(settled_file("r", NodeId{3})));
  EXPECT_FALSE(is_settled_name(scratch_file("r", ScratchKind::settled, tile)));  // of older software
}

}  // namespace
}  // namespace tessera
