// open_run trusts nothing: a plan that does not fit its files is refused with one sentence.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "src/base/files/checksum.h"
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
  refused("/bundles/0/points", UINT64_MAX);
  refused("/bundles/0/first_id", 501);
  refused("/bundles/0/attempt", UINT64_MAX);
  refused("/bundles/0/number", nullptr);
  refused("/segments_xxh3", "0123456789abcde");
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

TEST_F(Plan, IsRefusedWhenAFileIsMissingOrOfAnotherSize) {
  for (const char* name : {"points/000000-000000.bin", "segments.bin"}) {
    const auto file = run_folder() / name;
    const std::string content = read_text(file);
    write_text(file, content + "x");
    expect_refused(Errc::corrupt, name);
    write_text(file, content.substr(40));
    expect_refused(Errc::corrupt, name);
    std::filesystem::remove(file);
    expect_refused(Errc::io, name);
    write_text(file, content);
    EXPECT_TRUE(open_run(run_folder()));
  }
}

// With the right checksum, as nobody writes them.
TEST_F(Plan, IsRefusedWithSegmentsThatCannotBe) {
  const auto file = run_folder() / "segments.bin";
  const auto segments = open_run(run_folder()).value().segments;
  ASSERT_EQ(segments.size(), 3u);
  const auto refused = [&](auto change) {
    auto changed = segments;
    change(changed);
    const auto bytes = std::as_bytes(std::span(changed));
    write_text(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    auto plan = unsealed();
    plan["segments_xxh3"] = checksum_text(checksum(bytes));
    write_plan_of(plan);
    expect_refused(Errc::corrupt, "segments.bin");
  };
  refused([](auto& s) { s[1].bundle = 1; });
  refused([](auto& s) { s[1].count = 0; });
  refused([](auto& s) { s[1].count -= 1; });
  refused([](auto& s) { s[1].begin = 500; });
  refused([](auto& s) { s[1].begin = UINT64_MAX; });
  refused([](auto& s) { s.pop_back(); });
  refused([](auto& s) { s.push_back(s.back()); });
}

TEST_F(Plan, DoesNotHideARecordThatCannotBeInItsTile) {
  const auto file = run_folder() / "points" / "000000-000000.bin";
  const std::string content = read_text(file);
  auto run = open_run(run_folder()).value();
  const auto begin = run.segments_of(TileId{1})[0].begin * 32;
  Segment& segment = run.segments[1];
  const auto refused = [&](std::size_t at, std::size_t bytes, const std::string& by) {
    auto changed = content;
    changed.replace(begin + at, bytes, by);
    write_text(file, changed);
    EXPECT_EQ(load_tile(run, TileId{1}).error().code, Errc::corrupt) << "whatever the checksum";
    const auto records = std::as_bytes(std::span(changed)).subspan(begin, segment.count * 32);
    segment.points_sum = record_checksum(records, 32, segment.begin);
    const auto tile = load_tile(run, TileId{1});
    ASSERT_FALSE(tile);
    EXPECT_EQ(tile.error().code, Errc::corrupt);
    EXPECT_EQ(tile.error().where.find(file.string()), 0u);
  };
  refused(64, 32, std::string(32, '\0'));
  refused(64, 8, std::string(8, '\xff'));
  refused(64, 32, content.substr(begin, 32));
  refused(0, 64, content.substr(0, 64));
}

TEST_F(Plan, IsMissingInAFolderThatIsNotARun) {
  const auto run = open_run(folder_);
  ASSERT_FALSE(run);
  EXPECT_EQ(run.error().code, Errc::io);
  EXPECT_EQ(run.error().where, (folder_ / "plan.json").string() + ": cannot open: No such file or directory");
}

}  // namespace
}  // namespace tessera
