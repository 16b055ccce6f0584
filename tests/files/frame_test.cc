#include "src/base/files/frame.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <span>
#include <string>

#include "src/base/files/checksum.h"
#include "src/base/flat_codec.h"
#include "tests/files/files_testing.h"

namespace tessera {
namespace {

constexpr auto kind = ScratchKind::mail;
constexpr FrameOwner owner{7, 42};
using Payloads = std::vector<BigVector<std::byte>>;

class Frame : public FolderFixture {
 protected:
  std::filesystem::path path() const { return folder() / "frames"; }
};

Result<Payloads> read_all(const std::filesystem::path& path) {
  Payloads payloads;
  BOOST_OUTCOME_TRYV(for_each_frame(path, kind, owner, [&](BigVector<std::byte> payload) -> Status {
    payloads.push_back(std::move(payload));
    return success();
  }));
  return payloads;
}

template <class T>
void expect_corrupt(const Result<T>& result, const std::filesystem::path& path, const std::string& fault) {
  ASSERT_FALSE(result) << fault;
  EXPECT_EQ(result.error().code, Errc::corrupt) << fault;
  EXPECT_NE(result.error().where.find(path.string()), std::string::npos) << result.error().where;
}

TEST_F(Frame, IsReadAsItWasWritten) {
  for (const std::size_t size : {0, 1, 7, 8, 100'000}) {
    const BigVector<std::byte> payload(size, std::byte{42});
    ASSERT_TRUE(write_frame(path(), kind, owner, payload));
    EXPECT_EQ(std::filesystem::file_size(path()), size + frame_header_bytes);
    const auto read = read_frame(path(), kind, owner);
    ASSERT_TRUE(read);
    EXPECT_EQ(read.value(), payload);
  }
}

TEST_F(Frame, ReplacesTheOneBeforeAndLeavesNoTemporaryName) {
  ASSERT_TRUE(write_frame(path(), kind, owner, to_bytes("one")));
  ASSERT_TRUE(write_frame(path(), kind, owner, to_bytes("two")));
  EXPECT_EQ(read_frame(path(), kind, owner).value(), to_bytes("two"));
  EXPECT_FALSE(std::filesystem::exists(temporary_name(path())));
}

TEST_F(Frame, AppendedFramesComeBackInOrder) {
  const Payloads payloads{to_bytes("a"), {}, to_bytes("three")};
  for (const auto& payload : payloads) ASSERT_TRUE(append_frame(path(), kind, owner, payload));
  const auto read = read_all(path());
  ASSERT_TRUE(read);
  EXPECT_EQ(read.value(), payloads);
}

TEST_F(Frame, DamageOfAFileOfOneIsCorruptWhereverItIs) {
  ASSERT_TRUE(write_frame(path(), kind, owner, to_bytes("payload")));
  for_each_damage(path(),
                  [&](const std::string& fault) { expect_corrupt(read_frame(path(), kind, owner), path(), fault); });
  EXPECT_EQ(read_frame(path(), kind, owner).value(), to_bytes("payload"));
}

// A file cut between two frames is one of fewer frames: the one fault that only who appended can tell.
TEST_F(Frame, DamageOfAFileOfSeveralIsCorruptButForWholeFramesThatAreMissing) {
  const Payloads payloads{to_bytes("a"), {}, to_bytes("bc")};
  for (const auto& payload : payloads) ASSERT_TRUE(append_frame(path(), kind, owner, payload));
  std::size_t fewer = 0;
  for_each_damage(path(), [&](const std::string& fault) {
    const auto read = read_all(path());
    if (!read) return expect_corrupt(read, path(), fault);
    ++fewer;
    EXPECT_LT(read.value().size(), payloads.size()) << fault;
    EXPECT_EQ(read.value(), Payloads(payloads.begin(), payloads.begin() + static_cast<int>(read.value().size())));
  });
  EXPECT_EQ(fewer, payloads.size());
}

TEST_F(Frame, OfAnotherKindIsCorrupt) {
  ASSERT_TRUE(write_frame(path(), ScratchKind::state, owner, to_bytes("payload")));
  expect_corrupt(read_frame(path(), kind, owner), path(), "another kind");
  expect_corrupt(read_all(path()), path(), "another kind");
}

// As when files were exchanged, or put back from another run.
TEST_F(Frame, OfAnotherOwnerIsCorrupt) {
  for (const FrameOwner other : {FrameOwner{8, 42}, FrameOwner{7, 43}}) {
    ASSERT_TRUE(write_frame(path(), kind, other, to_bytes("payload")));
    expect_corrupt(read_frame(path(), kind, owner), path(), "another owner");
    expect_corrupt(read_all(path()), path(), "another owner");
    expect_corrupt(read_frame_at(path(), kind, owner, 0), path(), "another owner");
  }
}

// Whole by the checksum that it had, which is not looked at: it does not say whose it is.
TEST_F(Frame, OfOlderSoftwareIsCorrupt) {
  for (const std::string payload : {"", "payload", "a payload that is longer than what a header has more"}) {
    const std::uint32_t fields[] = {0x72467354, static_cast<std::uint32_t>(kind),
                                    static_cast<std::uint32_t>(payload.size()), 0};
    std::uint64_t sum = checksum(std::as_bytes(std::span(payload)), checksum(std::as_bytes(std::span(fields))));
    auto bytes = BigVector<std::byte>(sizeof fields + sizeof sum);
    std::memcpy(bytes.data(), fields, sizeof fields);
    std::memcpy(bytes.data() + sizeof fields, &sum, sizeof sum);
    for (const char c : payload) bytes.push_back(static_cast<std::byte>(c));
    ASSERT_TRUE(write_whole(path(), bytes));
    const auto read = read_frame(path(), kind, owner);
    expect_corrupt(read, path(), payload);
    EXPECT_NE(read.error().where.find("an older version of Tessera"), std::string::npos) << read.error().where;
    EXPECT_TRUE(frame_offsets(path(), kind).value().empty());
  }
}

// The length is believed only as far as the file goes: no allocation for what is not there.
TEST_F(Frame, OfAnImpossibleLengthIsCorrupt) {
  ASSERT_TRUE(write_frame(path(), kind, owner, to_bytes("payload")));
  auto bytes = read_whole(path()).value();
  for (std::size_t i = 8; i < 16; ++i) bytes[i] = std::byte{0xff};
  ASSERT_TRUE(write_whole(path(), bytes));
  expect_corrupt(read_frame(path(), kind, owner), path(), "length");
}

TEST_F(Frame, OfTwoInAFileForOneIsCorrupt) {
  ASSERT_TRUE(append_frame(path(), kind, owner, to_bytes("a")));
  ASSERT_TRUE(append_frame(path(), kind, owner, to_bytes("b")));
  expect_corrupt(read_frame(path(), kind, owner), path(), "two frames");
}

TEST_F(Frame, ThatIsNotThereOrCannotBeWrittenIsAnErrorOfTheSystem) {
  EXPECT_EQ(read_frame(path(), kind, owner).error().code, Errc::io);
  EXPECT_EQ(read_all(path()).error().code, Errc::io);
  EXPECT_EQ(append_frame(folder() / "no" / "folder", kind, owner, {}).error().code, Errc::io);
  EXPECT_EQ(write_frame(folder() / "no" / "folder", kind, owner, {}).error().code, Errc::io);
  EXPECT_EQ(append_frame("/dev/full", kind, owner, {}).error().code, Errc::io);
}

TEST_F(Frame, VisitStopsAtItsOwnError) {
  ASSERT_TRUE(append_frame(path(), kind, owner, to_bytes("a")));
  ASSERT_TRUE(append_frame(path(), kind, owner, to_bytes("b")));
  int seen = 0;
  const auto status = for_each_frame(path(), kind, owner, [&](const auto&) -> Status {
    ++seen;
    return error(Errc::internal, "enough");
  });
  EXPECT_EQ(status.error().where, "enough");
  EXPECT_EQ(seen, 1);
}

struct Flat {
  std::uint32_t value = 0;
  std::vector<std::uint64_t> list;
  std::vector<double> empty;
  friend bool operator==(const Flat&, const Flat&) = default;
};

BigVector<std::byte> write_flat(const Flat& flat) {
  FlatWriter out;
  out.value(flat.value);
  out.list(flat.list);
  out.list(flat.empty);
  return out.take();
}

bool read_flat(std::span<const std::byte> bytes, Flat& flat) {
  FlatReader in(bytes);
  return in.value(flat.value) && in.list(flat.list) && in.list(flat.empty) && in.at_end();
}

TEST(FlatCodec, ReadsWhatItWroteAndNoTruncationOfIt) {
  const Flat flat{7, {1, 2, 3}, {}};
  const auto bytes = write_flat(flat);
  Flat read;
  ASSERT_TRUE(read_flat(bytes, read));
  EXPECT_EQ(read, flat);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    Flat cut;
    EXPECT_FALSE(read_flat(std::span(bytes).first(size), cut)) << size;
  }
}

TEST(FlatCodec, AllocatesNoMoreThanIsThere) {
  FlatWriter out;
  out.value(std::uint64_t{1} << 61);
  const auto bytes = out.take();
  std::vector<std::uint64_t> list;
  EXPECT_FALSE(FlatReader(bytes).list(list));
}

}  // namespace
}  // namespace tessera
