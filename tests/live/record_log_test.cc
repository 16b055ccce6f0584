// A log keeps what was appended: a torn end is cut off, and all other damage is an error.
#include "src/base/files/record_log.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <filesystem>
#include <string>
#include <vector>

#include "src/base/files/whole_file.h"
#include "tests/store/sample_result.h"

namespace tessera::testing {
namespace {

std::vector<std::byte> bytes_of(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

class Records : public ::testing::Test {
 protected:
  // The texts in the log, or the error.
  Result<std::vector<std::string>> read() const {
    std::vector<std::string> out;
    BOOST_OUTCOME_TRY(log, RecordLog::open(path_, [&](std::uint32_t, std::span<const std::byte> payload) -> Status {
                        out.emplace_back(as_text(payload));
                        return success();
                      }));
    EXPECT_EQ(log.records(), out.size());
    return out;
  }
  void append(const std::vector<std::string>& texts) const {
    auto log = RecordLog::open(path_, [](std::uint32_t, std::span<const std::byte>) { return success(); });
    ASSERT_TRUE(log) << log.error().where;
    for (const std::string& text : texts) ASSERT_TRUE(log.value().append(1, bytes_of(text)));
  }
  std::vector<std::byte> content() const { return read_whole(path_).value(); }
  void put(std::span<const std::byte> bytes) const { ASSERT_TRUE(write_whole(path_, bytes)); }

  test::TemporaryFolder scratch_;
  std::filesystem::path path_ = scratch_.path() / "a.log";
  std::vector<std::string> texts_{"first", "", "a third record", std::string(700, 'x')};
};

TEST_F(Records, AreReadInOrderAndGrow) {
  append({"first", ""});
  append({"a third record", std::string(700, 'x')});
  EXPECT_EQ(read().value(), texts_);
}

TEST_F(Records, LoseATornEndAlone) {
  append(texts_);
  const auto whole = content();
  std::vector<std::size_t> ends{0};
  for (const std::string& text : texts_) ends.push_back(ends.back() + 40 + text.size());
  ASSERT_EQ(ends.back(), whole.size());
  for (std::size_t size = 0; size <= whole.size(); ++size) {
    put(std::span(whole).first(size));
    const auto left = read();
    ASSERT_TRUE(left) << left.error().where;
    const auto kept = static_cast<std::size_t>(std::upper_bound(ends.begin(), ends.end(), size) - ends.begin()) - 1;
    EXPECT_EQ(left.value(),
              std::vector<std::string>(texts_.begin(), texts_.begin() + static_cast<std::ptrdiff_t>(kept)));
    EXPECT_EQ(content().size(), ends[kept]);
    append({"more"});
    EXPECT_EQ(read().value().back(), "more");
  }
}

TEST_F(Records, MayEndInZeros) {
  append(texts_);
  auto whole = content();
  whole.resize(whole.size() + 5000);
  put(whole);
  EXPECT_EQ(read().value(), texts_);
}

TEST_F(Records, AreDamagedByAnyFlippedBit) {
  append(texts_);
  const auto whole = content();
  for (std::size_t at = 0; at < whole.size(); ++at) {
    auto bad = whole;
    bad[at] ^= std::byte{4};
    put(bad);
    const auto left = read();
    ASSERT_FALSE(left) << "byte " << at;
    EXPECT_EQ(left.error().code, Errc::corrupt);
    EXPECT_NE(left.error().where.find("a.log, byte "), std::string::npos) << left.error().where;
  }
}

// As a full disk does it: a part of the record is written.
TEST_F(Records, AreAsBeforeAfterOneThatHasNoRoom) {
  append(texts_);
  const auto whole = content();
  {
    auto log = RecordLog::open(path_, [](std::uint32_t, std::span<const std::byte>) { return success(); });
    ASSERT_TRUE(log) << log.error().where;
    const auto handler = ::signal(SIGXFSZ, SIG_IGN);
    rlimit before{};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
    const rlimit small{whole.size() + 50, before.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
    const Status refused = log.value().append(1, bytes_of(std::string(500, 'y')));
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
    ::signal(SIGXFSZ, handler);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, Errc::io);
    EXPECT_TRUE(log.value().intact());
    EXPECT_EQ(content(), whole);
    ASSERT_TRUE(log.value().append(1, bytes_of("more")));
  }
  texts_.emplace_back("more");
  EXPECT_EQ(read().value(), texts_);
}

TEST_F(Records, MayNotBeMissing) {
  append(texts_);
  auto whole = content();
  whole.erase(whole.begin() + 45, whole.begin() + 85);  // the empty record
  put(whole);
  const auto left = read();
  ASSERT_FALSE(left);
  EXPECT_NE(left.error().where.find("record 2 stands where record 1 should be"), std::string::npos);
}

}  // namespace
}  // namespace tessera::testing
