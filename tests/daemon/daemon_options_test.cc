#include "src/front/daemon/daemon_options.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

namespace tessera::daemon {
namespace {

class Options : public ::testing::Test {
 protected:
  Options() { add_daemon_options(app_, settings_); }
  ~Options() override { std::filesystem::remove(file_); }

  void write_file(const std::string& text) { std::ofstream(file_) << text; }
  Result<DaemonOptions> read(const std::string& flags) {
    app_.parse(flags);
    return read_daemon_options(settings_, [this](const char* name) {
      const auto found = environment_.find(name);
      return found == environment_.end() ? nullptr : found->second.c_str();
    });
  }

  CLI::App app_;
  DaemonSettings settings_;
  std::map<std::string, std::string> environment_;
  const std::string file_ = std::string(::testing::TempDir()) + "daemon_options_" +
                            ::testing::UnitTest::GetInstance()->current_test_info()->name() + ".toml";
};

TEST_F(Options, ListensOnTheLoopbackUnlessToldOtherwise) {
  const auto options = read("--data /tmp/d");
  ASSERT_TRUE(options);
  ASSERT_EQ(options.value().http.listeners.size(), 2u);
  EXPECT_EQ(options.value().http.listeners[0].address, "127.0.0.1");
  EXPECT_EQ(options.value().http.listeners[0].port, 7070);
  EXPECT_FALSE(options.value().http.listeners[0].operations);
  EXPECT_EQ(options.value().http.listeners[1].port, 7071);
  EXPECT_TRUE(options.value().http.listeners[1].operations);
  EXPECT_FALSE(options.value().http.insecure);
  EXPECT_FALSE(options.value().service.uploads);
  EXPECT_EQ(options.value().service.retention_s, 0u);
  EXPECT_GT(options.value().service.memory_bytes, 0u);
}

TEST_F(Options, LiveResultsAreNamedOnceOrSeveralTimes) {
  auto options = read("--data /tmp/d --live a --live b,c --live-memory 100M");
  ASSERT_TRUE(options) << options.error().where;
  EXPECT_EQ(options.value().service.live, (std::vector<std::string>{"a", "b", "c"}));
  EXPECT_EQ(options.value().service.live_memory_bytes, std::uint64_t{100} << 20);
}

TEST_F(Options, FlagsBeatVariablesBeatTheFile) {
  write_file(
      "data = \"/from/file\"\nmemory = \"1G\"\njobs = 3\ninputs = [\"/a\", \"/b\"]\n[limits]\nqueued = 7\npoints = "
      "\"2M\"\n");
  environment_ = {{"TESSERAD_MEMORY", "2G"}, {"TESSERAD_JOBS", "4"}, {"TESSERAD_LIMITS_QUEUED", "8"}};
  const auto options = read("--config " + file_ + " --jobs 5 --metrics none");
  ASSERT_TRUE(options) << options.error().where;
  const service::ServiceOptions& service = options.value().service;
  EXPECT_EQ(service.data, "/from/file");
  EXPECT_EQ(service.memory_bytes, std::uint64_t{2} << 30);
  EXPECT_EQ(service.limits.running, 5u);
  EXPECT_EQ(service.limits.queued, 8u);
  EXPECT_EQ(service.limits.points, 2'000'000u);
  ASSERT_EQ(service.roots.size(), 2u);
  EXPECT_EQ(service.roots[1], "/b");
  EXPECT_EQ(options.value().http.listeners.size(), 1u);
}

TEST_F(Options, WhatIsWrongIsSaidWithItsPlace) {
  write_file("data = \"/d\"\n\nretention = \"soon\"\n");
  const auto options = read("--config " + file_);
  ASSERT_FALSE(options);
  EXPECT_EQ(options.error().code, Errc::usage);
  EXPECT_NE(options.error().where.find("line 3: retention: 'soon' is no time"), std::string::npos)
      << options.error().where;
}

TEST_F(Options, UnknownKeysAndTablesAreRefused) {
  write_file("datta = \"/d\"\n");
  EXPECT_NE(read("--config " + file_).error().where.find("line 1: there is no key 'datta'"), std::string::npos);
  write_file("[limit]\nqueued = 1\n");
  EXPECT_NE(read("").error().where.find("line 1: there is no table [limit]"), std::string::npos);
  write_file("[limits]\nquota = 1\n");
  EXPECT_NE(read("").error().where.find("line 2: [limits] has no key 'quota'"), std::string::npos);
}

TEST_F(Options, WithoutADataFolderThereIsASentence) {
  EXPECT_NE(read("").error().where.find("--data DIR is needed"), std::string::npos);
}

TEST(Address, HasAPortAndMayHaveAHost) {
  EXPECT_EQ(parse_listen_address("127.0.0.1:80").value().port, 80);
  EXPECT_EQ(parse_listen_address("[::1]:80").value().address, "::1");
  EXPECT_EQ(parse_listen_address("7070").value().address, "127.0.0.1");
  for (const char* wrong : {"", ":", ":80", "127.0.0.1:", "127.0.0.1:65536", "a:b", "1:-1"})
    EXPECT_FALSE(parse_listen_address(wrong)) << wrong;
}

TEST(Duration, HasAUnit) {
  EXPECT_EQ(parse_duration("30d").value(), 30u * 86'400);
  EXPECT_EQ(parse_duration("15m").value(), 900u);
  EXPECT_EQ(parse_duration("90").value(), 90u);
  EXPECT_EQ(parse_duration("forever").value(), 0u);
  for (const char* wrong : {"", "d", "-1d", "0", "1w", "1.5h"}) EXPECT_FALSE(parse_duration(wrong)) << wrong;
}

}  // namespace
}  // namespace tessera::daemon
