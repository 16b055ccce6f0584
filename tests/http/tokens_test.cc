#include "src/service/http/tokens.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "src/service/http/guard.h"
#include "src/service/http/secrets.h"

namespace tessera::service::http {
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
}

TEST_F(TokensFile, TellsTokensAndTheirMarksApart) {
  const std::string read(32, 'r'), submit(40, 's');
  write("# who\n\nana read " + read + "\nbob submit " + submit + "\n");
  const Tokens tokens = Tokens::open(file_).value();
  EXPECT_EQ(tokens.find(read)->name, "ana");
  EXPECT_EQ(tokens.find(submit)->role, Role::submit);
  EXPECT_FALSE(tokens.find(""));
  EXPECT_FALSE(tokens.find(read + "r"));
  const std::string mark = Tokens::mark_of(submit);
  EXPECT_EQ(tokens.find_mark(mark)->name, "bob");
  EXPECT_FALSE(tokens.find(mark));
  EXPECT_FALSE(tokens.find_mark(submit));
  EXPECT_FALSE(tokens.find_mark(Tokens::mark_of("another")));
}

TEST_F(TokensFile, IsRefusedWhenOthersCanReadItOrALineIsNone) {
  const std::string token(32, 't');
  for (const int rights : {0644, 0604, 0666, 0601}) {
    write("ana read " + token + "\n", rights);
    EXPECT_EQ(Tokens::open(file_).error().code, Errc::usage) << rights;
  }
  ASSERT_EQ(chmod(file_.c_str(), 0600), 0);
  const std::vector<std::string> wrong{"ana read short", "ana root " + token, "ana read", "ana read " + token + " more",
                                       ""};
  for (const std::string& line : wrong) {
    write(line + "\n");
    const auto tokens = Tokens::open(file_);
    ASSERT_FALSE(tokens) << line;
    EXPECT_EQ(tokens.error().code, Errc::usage);
  }
}

// Kubernetes gives a volume's files to a group whenever it mounts the volume (fsGroup): the daemon must start again.
TEST_F(TokensFile, IsMendedWhenOnlyItsGroupCanReadIt) {
  const std::string token(32, 't');
  for (const int rights : {0660, 0640, 0620}) {
    write("ana read " + token + "\n", rights);
    const auto tokens = Tokens::open(file_);
    ASSERT_TRUE(tokens) << rights << ": " << tokens.error().where;
    struct stat status {};
    ASSERT_EQ(stat(file_.c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777, 0600U) << rights;
  }
}

TEST_F(TokensFile, HasATokenOfANameOnce) {
  write("ana read " + std::string(32, 'r') + "\nana admin " + std::string(32, 'a') + "\n");
  const auto tokens = Tokens::open(file_);
  ASSERT_FALSE(tokens);
  EXPECT_NE(tokens.error().where.find("line 2: there is a token of the name 'ana' already"), std::string::npos);
}

TEST_F(TokensFile, MayBeEmptyWhenThatIsSaid) {
  write("# nobody\n");
  EXPECT_FALSE(Tokens::open(file_));
  const auto tokens = Tokens::open(file_, Tokens::Empty::allowed);
  ASSERT_TRUE(tokens);
  EXPECT_EQ(tokens.value().first(Role::admin), "");
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
}  // namespace tessera::service::http
