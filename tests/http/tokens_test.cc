#include "src/http/tokens.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "src/http/guard.h"

namespace tessera::http {
namespace {

namespace fs = std::filesystem;

class TokensFile : public testing::Test {
 protected:
  TokensFile() {
    folder_ = testing::TempDir() + "tokens-" + random_hex(8);
    fs::create_directories(folder_);
    file_ = folder_ / "tokens";
  }
  ~TokensFile() override { fs::remove_all(folder_); }
  void write(const std::string& text, int rights = 0600) {
    std::ofstream(file_) << text;
    ASSERT_EQ(chmod(file_.c_str(), static_cast<mode_t>(rights)), 0);
  }
  fs::path folder_, file_;
};

TEST_F(TokensFile, IsMadeForItsOwnerAlone) {
  const auto tokens = Tokens::open(file_);
  ASSERT_TRUE(tokens);
  struct stat status {};
  ASSERT_EQ(stat(file_.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600U);
  const std::string token = tokens.value().first(Role::admin);
  EXPECT_EQ(token.size(), 64U);
  EXPECT_EQ(tokens.value().find(token)->role, Role::admin);
  const auto again = Tokens::open(file_);
  EXPECT_EQ(again.value().first(Role::admin), token);
  EXPECT_EQ(again.value().session_of(token), tokens.value().session_of(token));
}

TEST_F(TokensFile, TellsTokensAndSessionsApart) {
  const std::string read(32, 'r'), submit(40, 's');
  write("# who\n\nana read " + read + "\nbob submit " + submit + "\n");
  const Tokens tokens = Tokens::open(file_).value();
  EXPECT_EQ(tokens.find(read)->name, "ana");
  EXPECT_EQ(tokens.find(submit)->role, Role::submit);
  EXPECT_FALSE(tokens.find(""));
  EXPECT_FALSE(tokens.find(read + "r"));
  const std::string session = tokens.session_of(submit);
  EXPECT_EQ(tokens.find_session(session)->name, "bob");
  EXPECT_FALSE(tokens.find(session));
  EXPECT_FALSE(tokens.find_session(submit));
  EXPECT_EQ(tokens.session_of("another"), "");
}

TEST_F(TokensFile, IsRefusedWhenOthersCanReadItOrALineIsNone) {
  const std::string token(32, 't');
  write("ana read " + token + "\n", 0640);
  EXPECT_EQ(Tokens::open(file_).error().code, Errc::usage);
  const std::vector<std::string> wrong{"ana read short", "ana root " + token, "ana read", "ana read " + token + " more",
                                       ""};
  for (const std::string& line : wrong) {
    write(line + "\n");
    const auto tokens = Tokens::open(file_);
    ASSERT_FALSE(tokens) << line;
    EXPECT_EQ(tokens.error().code, Errc::usage);
  }
}

TEST(FailureRate, IsBoundedForAnAddressAndComesBack) {
  FailureRate rate(3, 1);
  const auto now = FailureRate::Clock::now();
  for (int at = 0; at < 3; ++at) EXPECT_TRUE(rate.allow("a", now));
  EXPECT_FALSE(rate.allow("a", now));
  EXPECT_TRUE(rate.allow("b", now));
  EXPECT_TRUE(rate.allow("a", now + std::chrono::seconds(1)));
  EXPECT_FALSE(rate.allow("a", now + std::chrono::seconds(1)));
}

TEST(Host, IsFoundWithAndWithoutAPort) {
  EXPECT_EQ(host_of("Example.ORG:80"), "example.org");
  EXPECT_EQ(host_of("example.org."), "example.org");
  EXPECT_EQ(host_of("[::1]:8080"), "[::1]");
  EXPECT_EQ(host_of("127.0.0.1"), "127.0.0.1");
  EXPECT_EQ(host_of("127.0.0.1:80@evil"), "");
  EXPECT_EQ(host_of("[::1"), "");
}

}  // namespace
}  // namespace tessera::http
