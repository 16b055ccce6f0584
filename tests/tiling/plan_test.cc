// open_run trusts nothing: a plan that does not fit its files is refused with one sentence.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "src/tiling/plan.h"
#include "tests/tiling/run_fixture.h"

namespace tessera {
namespace {

class Plan : public RunFixture {
 protected:
  void SetUp() override {
    const auto run = route_points(make_cloud("uniform", 3, 500), 3, {.tiles = 3, .options_key = "key"});
    ASSERT_TRUE(run) << run.error().where;
    text_ = read_text(run_folder() / "plan.json");
  }

  void expect_refused(Errc code, const std::string& file) const {
    const auto run = open_run(run_folder());
    ASSERT_FALSE(run);
    EXPECT_EQ(run.error().code, code) << run.error().where;
    EXPECT_EQ(run.error().where.find((run_folder() / file).string() + ": "), 0u) << run.error().where;
  }

  // Without the checksum: what is wrong is not found by it.
  nlohmann::json unsealed() const {
    auto plan = nlohmann::json::parse(text_);
    plan.erase("xxh3");
    return plan;
  }
  void write_plan_of(const nlohmann::json& plan) const {
    write_text(run_folder() / "plan.json", sealed_plan(plan.dump()));
  }

  std::string text_;
};

TEST_F(Plan, IsRefusedWhenCutShortAnywhere) {
  for (std::size_t n = 0; n < text_.size(); n += 7) {
    write_text(run_folder() / "plan.json", text_.substr(0, n));
    expect_refused(Errc::corrupt, "plan.json");
  }
}

TEST_F(Plan, IsRefusedWhenAFieldIsMissingOrOfAnotherType) {
  const auto plan = unsealed();
  for (const auto& [key, value] : plan.items()) {
    for (const nlohmann::json& other : {nlohmann::json(), nlohmann::json("text"), nlohmann::json(-1),
                                        nlohmann::json(1e300), nlohmann::json::array({7}), nlohmann::json::object()}) {
      if (value.is_string() && other.is_string()) continue;
      auto changed = plan;
      changed[key] = other;
      write_plan_of(changed);
      expect_refused(Errc::corrupt, "plan.json");
    }
    auto changed = plan;
    changed.erase(key);
    write_plan_of(changed);
    expect_refused(Errc::corrupt, "plan.json");
  }
}

TEST_F(Plan, IsRefusedWhenItsNumbersDoNotAddUp) {
  const auto plan = unsealed();
  const auto refused = [&](const char* pointer, const nlohmann::json& value) {
    SCOPED_TRACE(pointer);
    auto changed = plan;
    changed[nlohmann::json::json_pointer(pointer)] = value;
    write_plan_of(changed);
    expect_refused(Errc::corrupt, "plan.json");
  };
  refused("/version", 1);
  refused("/version", 2);
  refused("/counts/read", 501);
  refused("/counts/read", UINT64_MAX);
  refused("/counts/invalid", 1);
  refused("/counts/filtered", UINT64_MAX);
  refused("/tiles/1/points", 0);
  refused("/tiles/1/points", UINT64_MAX);
  refused("/tiles/1/bounds", nullptr);
  refused("/tiles/1/points_xxh3", "0123456789abcde");
  refused("/tiles/1/attributes_xxh3", nullptr);
  refused("/tiles/1/bounds/0/0", 1e9);
  refused("/seeds/0/id", 500);
  refused("/seeds/0/at/1", nullptr);
  refused("/seeds/0", nullptr);
  refused("/seeds/0/reach", -1);
  refused("/seeds/0/reach", "far");
  refused("/seeds", nlohmann::json::array());
  refused("/partition/tiles", 4);
  refused("/inputs/0/bytes", -1);
}

TEST_F(Plan, IsRefusedWhenAnyBitOfItIsFlipped) {
  for (std::size_t bit = 0; bit < 8 * text_.size(); bit += 5) {
    auto damaged = text_;
    damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << bit % 8));
    write_text(run_folder() / "plan.json", damaged);
    expect_refused(Errc::corrupt, "plan.json");
  }
  write_text(run_folder() / "plan.json", text_);
  EXPECT_TRUE(open_run(run_folder()));
}

TEST_F(Plan, IsRefusedWhenATileFileIsMissingOrOfAnotherSize) {
  const auto file = run_folder() / "points" / "000001.bin";
  const std::string content = read_text(file);
  write_text(file, content + "x");
  expect_refused(Errc::corrupt, "points/000001.bin");
  write_text(file, content.substr(32));
  expect_refused(Errc::corrupt, "points/000001.bin");
  std::filesystem::remove(file);
  expect_refused(Errc::io, "points/000001.bin");
  write_text(file, content);
  EXPECT_TRUE(open_run(run_folder()));
}

TEST_F(Plan, DoesNotHideARecordThatCannotBeInItsTile) {
  const auto run = open_run(run_folder()).value();
  const auto file = run_folder() / "points" / "000001.bin";
  const std::string content = read_text(file);
  const auto refused = [&](std::string changed) {
    write_text(file, changed);
    const auto tile = load_tile(run, TileId{1});
    ASSERT_FALSE(tile);
    EXPECT_EQ(tile.error().code, Errc::corrupt);
    EXPECT_EQ(tile.error().where.find(file.string()), 0u);
  };
  refused(std::string(content).replace(64, 32, 32, '\0'));
  refused(std::string(content).replace(64, 8, 8, '\xff'));
  refused(std::string(content).replace(64, 32, content, 0, 32));
  refused(content.substr(32));
  refused(read_text(run_folder() / "points" / "000000.bin"));
}

TEST_F(Plan, IsMissingInAFolderThatIsNotARun) {
  const auto run = open_run(folder_);
  ASSERT_FALSE(run);
  EXPECT_EQ(run.error().code, Errc::io);
  EXPECT_EQ(run.error().where, (folder_ / "plan.json").string() + ": cannot open: No such file or directory");
}

}  // namespace
}  // namespace tessera
