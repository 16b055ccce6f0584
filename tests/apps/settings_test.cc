#include "src/front/apps/settings.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>

#include "src/front/apps/machine_options.h"
#include "src/job/arguments.h"
#include "src/job/machine.h"

namespace tessera::apps {
namespace {

class SettingsTest : public testing::Test {
 protected:
  SettingsTest() {
    for (const auto* key : {"threads", "memory", "tiles", "max-points-per-tile", "crop", "quiet"})
      settings_.declare(key);
    settings_.declare("output", true);
    verify_.declare("memory");
  }
  ~SettingsTest() override { std::filesystem::remove(path_); }

  Status load(const std::string& toml) {
    std::ofstream(path_) << toml;
    return load_settings_file(path_, {&settings_, &verify_});
  }
  void environment(std::map<std::string, std::string> variables) {
    settings_.load_environment([&](const char* name) {
      const auto found = variables.find(name);
      return found == variables.end() ? nullptr : found->second.c_str();
    });
  }
  std::string refusal(const std::string& toml) {
    const auto status = load(toml);
    return status ? "" : status.error().where;
  }

  Settings settings_{"triangulate"}, verify_{"verify"};
  std::filesystem::path path_ = std::filesystem::path(testing::TempDir()) /
                                (std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) + ".toml");
};

TEST_F(SettingsTest, FlagsBeatTheEnvironmentBeatsTheFileInWhateverOrderTheyAreRead) {
  settings_.set_flag("threads", "3");
  environment({{"TESSERA_THREADS", "2"}, {"TESSERA_MEMORY", "2G"}});
  ASSERT_TRUE(load("[triangulate]\nthreads = 1\nmemory = '1G'\ntiles = 7\n"));
  EXPECT_EQ(settings_.text("threads"), "3");
  EXPECT_EQ(settings_.text("memory"), "2G");
  EXPECT_EQ(settings_.text("tiles"), "7");
  EXPECT_EQ(settings_.text("crop"), std::nullopt);

  Settings other{"triangulate"};
  for (const auto* key : {"threads", "memory", "tiles"}) other.declare(key);
  ASSERT_TRUE(load_settings_file(path_, {&other}));
  EXPECT_EQ(other.text("threads"), "1");
  other.load_environment([](const char*) { return "2"; });
  EXPECT_EQ(other.text("threads"), "2");
  other.set_flag("threads", "3");
  EXPECT_EQ(other.text("threads"), "3");
}

TEST_F(SettingsTest, DashesOfAKeyAreUnderscoresInItsVariable) {
  environment({{"TESSERA_MAX_POINTS_PER_TILE", "10k"}});
  EXPECT_EQ(settings_.text("max-points-per-tile"), "10k");
}

TEST_F(SettingsTest, TablesBelongToTheirCommand) {
  ASSERT_TRUE(load("[verify]\nmemory = '1G'\n"));
  EXPECT_EQ(settings_.text("memory"), std::nullopt);
  EXPECT_EQ(verify_.text("memory"), "1G");
}

TEST_F(SettingsTest, FilesMayHoldListsNumbersAndSwitches) {
  ASSERT_TRUE(load("[triangulate]\ncrop = [0.5, -1, 10, 20.25]\nquiet = true\n"));
  EXPECT_EQ(settings_.text("crop"), "0.5,-1,10,20.25");
  EXPECT_TRUE(settings_.on("quiet").value());
}

TEST_F(SettingsTest, AnUnknownKeyIsAnErrorWithFileAndLine) {
  EXPECT_EQ(refusal("[triangulate]\nthreads = 1\nthraeds = 2\n"),
            path_.string() + ", line 3: [triangulate] has no key 'thraeds'");
  EXPECT_NE(refusal("\n[triangle]\n").find(", line 2: there is no table [triangle]"), std::string::npos);
  EXPECT_NE(refusal("threads = 2\n").find(", line 1: "), std::string::npos);
}

TEST_F(SettingsTest, WhatIsNotTomlIsAnErrorWithFileAndLine) {
  EXPECT_NE(refusal("[triangulate]\nthreads = = 2\n").find(path_.string() + ", line 2: "), std::string::npos);
  EXPECT_NE(refusal("[triangulate]\nthreads = { a = 1 }\n").find(", line 2: threads: "), std::string::npos);
}

TEST_F(SettingsTest, OptionsOfOneRunAreRefusedInFilesAndIgnoredInTheEnvironment) {
  EXPECT_NE(refusal("[triangulate]\noutput = 'out'\n").find("command line only"), std::string::npos);
  environment({{"TESSERA_OUTPUT", "out"}});
  EXPECT_EQ(settings_.text("output"), std::nullopt);
}

TEST_F(SettingsTest, AMissingFileIsAnIoError) {
  const auto status = load_settings_file("/nowhere/tessera.toml", {&settings_});
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, Errc::io);
}

TEST_F(SettingsTest, AWrongValueNamesItsSource) {
  const auto parse = [](const std::string& text) { return parse_integer(text, 1, 8); };
  ASSERT_TRUE(load("[triangulate]\n\nthreads = 99\n"));
  EXPECT_TRUE(settings_.get("threads", parse).error().where.starts_with(path_.string() + ", line 3: threads: '99'"));
  environment({{"TESSERA_THREADS", "x"}});
  EXPECT_TRUE(settings_.get("threads", parse).error().where.starts_with("TESSERA_THREADS: 'x'"));
  settings_.set_flag("threads", "y");
  EXPECT_TRUE(settings_.get("threads", parse).error().where.starts_with("--threads: 'y'"));
}

TEST_F(SettingsTest, OfTwoContradictingKeysTheStrongerSourceStays) {
  ASSERT_TRUE(load("[triangulate]\ntiles = 4\n"));
  settings_.set_flag("max-points-per-tile", "10k");
  ASSERT_TRUE(settings_.exclusive("tiles", "max-points-per-tile"));
  EXPECT_EQ(settings_.text("tiles"), std::nullopt);
  EXPECT_EQ(settings_.text("max-points-per-tile"), "10k");
}

TEST_F(SettingsTest, TwoContradictingKeysOfOneSourceAreRefused) {
  settings_.set_flag("tiles", "4");
  settings_.set_flag("max-points-per-tile", "10k");
  const auto status = settings_.exclusive("tiles", "max-points-per-tile");
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().where, "--tiles and --max-points-per-tile contradict each other: give one of them");
}

TEST_F(SettingsTest, MemoryAndThreadsAreTheMachinesUnlessTheyAreGiven) {
  const auto near = [](std::uint64_t memory) {  // others take and give back meanwhile
    return memory > default_memory() / 4 && memory / 4 < default_memory();
  };
  EXPECT_TRUE(near(memory_option(settings_).value()));
  EXPECT_EQ(threads_option(settings_).value(), usable_processors());
  ASSERT_TRUE(load("[triangulate]\nmemory = 'auto'\nthreads = 'auto'\n"));
  EXPECT_TRUE(near(memory_option(settings_).value()));
  EXPECT_EQ(threads_option(settings_).value(), usable_processors());
  environment({{"TESSERA_MEMORY", "3M"}, {"TESSERA_THREADS", "1024"}});
  EXPECT_EQ(memory_option(settings_).value(), 3U << 20);
  EXPECT_EQ(threads_option(settings_).value(), 1024U);
  settings_.set_flag("memory", "much");
  settings_.set_flag("threads", "0");
  EXPECT_TRUE(memory_option(settings_).error().where.starts_with("--memory: 'much'"));
  EXPECT_TRUE(threads_option(settings_).error().where.starts_with("--threads: '0'"));
}

}  // namespace
}  // namespace tessera::apps
