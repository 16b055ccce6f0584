#include "src/service/http/sessions.h"

#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <set>
#include <string>

#include "src/base/files/temporary.h"
#include "src/service/http/secrets.h"

namespace tessera::service::http {
namespace {

using Clock = Sessions::Clock;

class SessionsFile : public testing::Test {
 protected:
  const TemporaryFolder folder_ = TemporaryFolder::make().value();
  const std::filesystem::path file_ = folder_.path() / "sessions";
  const Clock::time_point now_ = Clock::now();
  const std::string ana_ = checksum_of_secret("ana"), bob_ = checksum_of_secret("bob");
};

TEST_F(SessionsFile, EndByThemselvesAndWhenTheyAreEnded) {
  Sessions sessions(file_);
  const std::string one = sessions.begin(ana_, now_).value(), other = sessions.begin(ana_, now_).value();
  EXPECT_NE(one, other);
  EXPECT_EQ(sessions.find(one, now_), ana_);
  EXPECT_FALSE(sessions.find(one + "0", now_));
  EXPECT_TRUE(sessions.find(one, now_ + Sessions::lifetime - std::chrono::seconds(1)));
  EXPECT_FALSE(sessions.find(one, now_ + Sessions::lifetime));
  ASSERT_TRUE(sessions.end(one));
  EXPECT_FALSE(sessions.find(one, now_));
  EXPECT_TRUE(sessions.find(other, now_));
  ASSERT_TRUE(sessions.end(one)) << "once more";
}

TEST_F(SessionsFile, OutliveTheProcessUnlessTheyHaveEnded) {
  std::string kept, ended;
  {
    Sessions sessions(file_);
    kept = sessions.begin(ana_, now_).value();
    ended = sessions.begin(bob_, now_).value();
    ASSERT_TRUE(sessions.end(ended));
  }
  Sessions sessions(file_);
  ASSERT_TRUE(sessions.load(now_));
  EXPECT_EQ(sessions.find(kept, now_), ana_);
  EXPECT_FALSE(sessions.find(ended, now_));
  Sessions later(file_);
  ASSERT_TRUE(later.load(now_ + Sessions::lifetime));
  EXPECT_FALSE(later.find(kept, now_));
}

TEST_F(SessionsFile, EndWithTheirToken) {
  Sessions sessions(file_);
  const std::string hers = sessions.begin(ana_, now_).value(), his = sessions.begin(bob_, now_).value();
  ASSERT_TRUE(sessions.end_unless([&](const std::string& mark) { return mark == bob_; }));
  EXPECT_FALSE(sessions.find(hers, now_));
  EXPECT_TRUE(sessions.find(his, now_));
}

TEST_F(SessionsFile, AreBoundedForAToken) {
  Sessions sessions(file_);
  const std::string oldest = sessions.begin(ana_, now_ - std::chrono::hours(1)).value();
  const std::string his = sessions.begin(bob_, now_ - std::chrono::hours(2)).value();
  for (std::size_t at = 1; at < Sessions::of_a_token_max; ++at) ASSERT_TRUE(sessions.begin(ana_, now_));
  EXPECT_TRUE(sessions.find(oldest, now_));
  ASSERT_TRUE(sessions.begin(ana_, now_));
  EXPECT_FALSE(sessions.find(oldest, now_));
  EXPECT_TRUE(sessions.find(his, now_));
}

TEST_F(SessionsFile, ThatIsNoneIsRefused) {
  for (const std::string line : {"x", "short mark 1", "0 0 0"}) {
    std::ofstream(file_) << line << "\n";
    Sessions sessions(file_);
    const Status loaded = sessions.load(now_);
    ASSERT_FALSE(loaded) << line;
    EXPECT_EQ(loaded.error().code, Errc::usage);
  }
  Sessions sessions(folder_.path() / "none");
  EXPECT_TRUE(sessions.load(now_));
}

}  // namespace
}  // namespace tessera::service::http
