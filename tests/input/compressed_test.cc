// gzip and Zstandard files: as their plain twins, or a sentence.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "src/input/bytes/spool.h"
#include "src/input/cloud/cloud.h"
#include "tests/input/compress.h"

namespace tessera::testing_io {
namespace {

namespace fs = std::filesystem;

Bytes file_bytes(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return bytes_of(std::string{std::istreambuf_iterator<char>(in), {}});
}

Result<Contents> read_packed(Bytes bytes, const std::string& name, const std::vector<Attribute>& schema = {}) {
  Spool spool{{}};
  BOOST_OUTCOME_TRY(source, spool.unpacked(memory_source(name, std::move(bytes))));
  BOOST_OUTCOME_TRY(reader, open_reader(share(std::move(source)), schema));
  return read_whole(*reader);
}

std::string lines(int n) {
  std::string text;
  for (int i = 0; i < n; ++i) text += std::to_string(i * 37 % 1009) + " " + std::to_string(i) + " 0.5\n";
  return text;
}

struct Format {
  const char* name;
  const char* ending;
  std::function<Bytes(const Bytes&)> pack;
};

class Compressed : public testing::TestWithParam<Format> {
 protected:
  static Bytes pack(const Bytes& plain) { return GetParam().pack(plain); }
  static std::string called(const std::string& name) { return name + GetParam().ending; }
};

TEST_P(Compressed, FilesOfEveryFormatGiveWhatTheirPlainTwinsGive) {
  int equal = 0;
  for (const auto& entry : fs::recursive_directory_iterator(TESSERA_TEST_DATA "/../fuzz/corpus")) {
    if (!entry.is_regular_file()) continue;
    const std::string name = entry.path().filename().string();
    const auto plain = file_bytes(entry.path());
    const auto expected = read_bytes(plain, name);
    const auto got = read_packed(pack(plain), called(name));
    ASSERT_EQ(got.has_value(), expected.has_value()) << name;
    if (!expected) continue;
    const auto schema = expected.value().info.attributes;
    EXPECT_EQ(read_packed(pack(plain), called(name), schema).value().rows,
              read_bytes(plain, name, schema).value().rows);
    EXPECT_EQ(got.value().points, expected.value().points) << name;
    EXPECT_EQ(got.value().info.format, expected.value().info.format);
    EXPECT_EQ(got.value().info.packing, GetParam().name);
    EXPECT_EQ(got.value().info.content_bytes, plain.size());
    EXPECT_EQ(got.value().info.bytes, pack(plain).size());
    EXPECT_EQ(got.value().info.path, called(name));
    ++equal;
  }
  EXPECT_GT(equal, 20);
}

TEST_P(Compressed, FilesAreKnownByTheirFirstBytesAndTheirContentToo) {
  const auto ply =
      bytes_of("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nend_header\n1 2\n");
  EXPECT_EQ(read_packed(pack(ply), "no ending").value().info.format, "ply");
  EXPECT_EQ(read_packed(pack(bytes_of("1 2 3\n")), "a.xyz").value().points, (std::vector<Point>{{1, 2, 3}}));
  EXPECT_EQ(read_packed(pack(bytes_of("1 2 3\n")), called("A.XYZ")).value().points, (std::vector<Point>{{1, 2, 3}}));
}

TEST_P(Compressed, StreamsInARowAreOne) {
  const auto whole = bytes_of(lines(1000)), part = bytes_of(lines(500));
  const Bytes rest(whole.begin() + static_cast<std::ptrdiff_t>(part.size()), whole.end());
  const auto read = read_packed(pack(part) + pack({}) + pack(rest), called("a.xyz"));
  EXPECT_EQ(read.value().points, read_bytes(whole, "a.xyz").value().points);
}

TEST_P(Compressed, FilesCutOffAnywhereAreRefused) {
  const auto whole = pack(bytes_of(lines(400)));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const auto read =
        read_packed(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)), called("a.xyz"));
    ASSERT_TRUE(read.has_error()) << size;
    EXPECT_EQ(read.error().code, Errc::bad_input);
    EXPECT_EQ(read.error().where.find(called("a.xyz") + ": "), 0u);
  }
  const Bytes half(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(whole.size() / 2));
  EXPECT_EQ(sentence(read_packed(half, called("a.xyz"))), called("a.xyz") + ": is cut off: its " + GetParam().name +
                                                              " stream has no end after " +
                                                              std::to_string(half.size()) + " bytes");
}

TEST_P(Compressed, FilesWithWrongBitsAreRefusedOrGiveTheSame) {
  const auto plain = bytes_of(lines(400)), whole = pack(plain);
  const auto expected = read_bytes(plain, "a.xyz").value().points;
  std::size_t refused = 0;
  for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
    auto bytes = whole;
    bytes[bit / 8] ^= static_cast<std::byte>(1u << bit % 8);
    const auto read = read_packed(bytes, called("a.xyz"));
    refused += read.has_error();
    if (read.has_value()) {
      ASSERT_EQ(read.value().points, expected) << bit;
    }
  }
  EXPECT_GT(refused, 8 * whole.size() * 9 / 10);
}

TEST_P(Compressed, FilesWithSomethingBehindThemAreRefused) {
  const auto whole = pack(bytes_of(lines(10)));
  for (const char* what : {"x", "garbage", "\x1fz", "(\xb5/"}) {
    EXPECT_EQ(sentence(read_packed(whole + bytes_of(what), called("a.xyz"))),
              called("a.xyz") + ": its " + GetParam().name + " stream ends at byte " + std::to_string(whole.size()) +
                  ", but the bytes after it are not such a stream; the file is damaged or not only " + GetParam().name);
  }
}

TEST_P(Compressed, FilesOfNoKnownContentAreRefusedBeforeAllOfThemIsUnpacked) {
  EXPECT_NE(sentence(read_packed(pack(bytes_of("something")), called("a.tar"))).find("unknown format"),
            std::string::npos);
  EXPECT_EQ(sentence(read_packed(pack(pack(bytes_of(lines(9)))), called("a.xyz"))),
            called("a.xyz") + ": is compressed twice; unpack it once");
  EXPECT_EQ(sentence(read_packed(pack({}), called("a.xyz"))), called("a.xyz") + ": is empty");
  // Cut off and of no known content: the latter is found first.
  auto large = pack(Bytes(2 << 20));
  large.resize(large.size() - 5);
  EXPECT_NE(sentence(read_packed(large, called("a.bin"))).find("unknown format"), std::string::npos);
}

// 1 GiB of zeros: the disk has to hold them, memory does not.
TEST_P(Compressed, BombsCostNoMemory) {
  const auto part = pack(Bytes(32 << 20));
  Bytes bomb;
  for (int i = 0; i < 32; ++i) bomb = std::move(bomb) + part;
  EXPECT_LT(bomb.size(), 2u << 20);
  struct rusage before {
  }, after{};
  ::getrusage(RUSAGE_SELF, &before);
  const auto read = read_packed(std::move(bomb), called("a.xyz"));
  ::getrusage(RUSAGE_SELF, &after);
  EXPECT_EQ(sentence(read), called("a.xyz") + ": is not text: it holds zero bytes");
  EXPECT_LT(after.ru_maxrss - before.ru_maxrss, 64 << 10) << "KiB";
}

TEST_P(Compressed, FilesShareAFewDescriptors) {
  const TempFolder folder;
  constexpr int files = 500;
  for (int i = 0; i < files; ++i)
    folder.write(std::to_string(1000 + i) + called(".xyz"), pack(bytes_of(std::to_string(i) + " 2 3\n")));
  struct rlimit old {};
  ::getrlimit(RLIMIT_NOFILE, &old);
  const struct rlimit few { 40, old.rlim_max };
  ::setrlimit(RLIMIT_NOFILE, &few);
  for (const std::uint32_t threads : {1u, 4u}) {
    const auto cloud = Cloud::open({folder.path().string()}, {.threads = threads});
    ASSERT_EQ(sentence(cloud), "");
    std::uint64_t next = 0;
    const auto counts = cloud.value().for_each_batch([&](CloudBatch& batch) -> Status {
      for (const auto& p : batch.points) {
        EXPECT_EQ(p.id.value, next);
        EXPECT_EQ(p.at.x, static_cast<double>(next++));
      }
      return success();
    });
    EXPECT_EQ(sentence(counts), "");
    EXPECT_EQ(next, std::uint64_t{files});
  }
  ::setrlimit(RLIMIT_NOFILE, &old);
}

INSTANTIATE_TEST_SUITE_P(Formats, Compressed,
                         testing::Values(Format{"gzip", ".gz", gzip},
                                         Format{"zstd", ".zst", [](const Bytes& plain) { return zstd(plain); }}),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(CompressedZstd, WindowsThatNeedMuchMemoryAreRefused) {
  EXPECT_EQ(sentence(read_packed(zstd(bytes_of(lines(100)), 28), "a.xyz.zst")),
            "a.xyz.zst: needs more than 128 MiB of memory to unpack; compress it at a level up to 19, and not in "
            "zstd's long mode");
  EXPECT_EQ(read_packed(zstd(bytes_of(lines(100)), 24), "a.xyz.zst").value().points.size(), 100u);
}

TEST(CompressedZstd, FramesToBeSkippedAreSkipped) {
  const auto skipped =
      bytes_of(std::string_view("\x5a\x2a\x4d\x18\x03\x00\x00\x00"
                                "abc",
                                11));
  EXPECT_EQ(read_packed(skipped + zstd(bytes_of(lines(100))) + skipped, "a.xyz.zst").value().points.size(), 100u);
}

TEST(Spooled, StopsWhenAsked) {
  std::stop_source source;
  Spool spool({}, source.get_token());
  source.request_stop();
  const auto stopped = spool.unpacked(memory_source("a.xyz.gz", gzip(bytes_of(lines(10)))));
  EXPECT_EQ(stopped.error().code, Errc::interrupted);
}

TEST(Spooled, UnpacksNoMoreThanItMay) {
  const auto bytes = bytes_of(lines(1000));
  Spool enough({}, {}, 2 * bytes.size());
  EXPECT_EQ(sentence(enough.unpacked(memory_source("a.xyz.gz", gzip(bytes)))), "");
  EXPECT_EQ(sentence(enough.unpacked(memory_source("b.xyz.gz", gzip(bytes)))), "");
  const auto third = enough.unpacked(memory_source("c.xyz.gz", gzip(bytes)));
  ASSERT_TRUE(third.has_error());
  EXPECT_EQ(third.error().code, Errc::memory);
  EXPECT_EQ(third.error().where.find("c.xyz.gz: is too large to unpack here"), 0u);
}

TEST(Spooled, LeavesNothingInItsFolderAndSaysWhenThereIsNone) {
  const TempFolder folder;
  Spool spool(folder.path());
  const auto source = spool.unpacked(memory_source("a.xyz.gz", gzip(bytes_of(lines(10)))));
  EXPECT_EQ(sentence(source), "");
  EXPECT_TRUE(fs::is_empty(folder.path()));
  Spool nowhere(folder.path() / "none");
  EXPECT_EQ(sentence(nowhere.unpacked(memory_source("a.xyz.gz", gzip(bytes_of(lines(10)))))),
            (folder.path() / "none").string() + ": a temporary file cannot be made: No such file or directory");
}

TEST(Spooled, KeepsWhatItWasMadeOfWhenTheFileChangesAfterwards) {
  const TempFolder folder;
  const auto path = folder.write("a.xyz.gz", gzip(bytes_of(lines(10)))).string();
  const auto cloud = Cloud::open({path}, {});
  folder.write("a.xyz.gz", gzip(bytes_of(lines(20))));
  EXPECT_EQ(cloud.value().for_each_batch([](CloudBatch&) -> Status { return success(); }).value().read, 10u);
}

}  // namespace
}  // namespace tessera::testing_io
