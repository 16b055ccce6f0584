#include <gtest/gtest.h>

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "src/job/report/progress_display.h"
#include "src/job/report/progress_line.h"

namespace tessera {
namespace {

ProgressSnapshot halfway() {
  ProgressSnapshot now;
  now.elapsed_s = 10;
  now.phase = Phase::triangulating;
  now.points_total = now.points_routed = 1000;
  now.points_triangulated = 500;
  now.tiles_total = 8;
  now.tiles_triangulated = 4;
  now.updates_sent = 7;
  now.updates_processed = 5;
  now.memory_bytes = 1 << 30;
  return now;
}

TEST(Progress, TheFractionGrowsFromPhaseToPhaseUpToOne) {
  auto now = halfway();
  double before = -1;
  for (const PhaseRow& row : phase_table) {
    now.phase = row.phase;
    EXPECT_GE(fraction_done(now), before) << row.name;
    before = fraction_done(now);
  }
  EXPECT_EQ(before, 1);
}

TEST(Progress, NothingKnownIsNothingDone) { EXPECT_EQ(fraction_done(ProgressSnapshot{}), 0); }

TEST(Progress, TheFractionIsWhatIsOverAndWhatCountersTellOfTheRest) {
  auto now = halfway();
  EXPECT_DOUBLE_EQ(fraction_done(now), 0.08 + 0.55 * 4 / 8);
  now.tiles_triangulated = 6;  // the greater of two
  EXPECT_DOUBLE_EQ(fraction_done(now), 0.08 + 0.55 * 6 / 8);
  now.phase = Phase::splaying;
  EXPECT_DOUBLE_EQ(fraction_done(now), 0.08 + 0.55);
  now.phase = Phase::collecting;
  now.tiles_stored = 2;
  EXPECT_DOUBLE_EQ(fraction_done(now), 0.08 + 0.55 + 0.12 + 0.25 * 2 / 8);
  now = {};
  now.phase = Phase::routing;
  now.points_total = 1000;
  now.points_routed = 250;
  EXPECT_DOUBLE_EQ(fraction_done(now), 0.02);
}

TEST(Progress, TilesAreThoseThatAreAsFarAsThePhaseGoes) {
  auto now = halfway();
  now.tiles_stored = 1;
  NodeProgress node;
  node.name = "a";
  node.tiles = 8;
  node.tiles_triangulated = 5;
  node.tiles_stored = 2;
  now.nodes = {node};
  for (const PhaseRow& row : phase_table) {
    now.phase = row.phase;
    const bool stored = row.phase >= Phase::collecting;
    const auto text = progress_text({}, now);
    EXPECT_NE(text.find(stored ? "tiles 1/8" : "tiles 4/8"), std::string::npos) << text;
    EXPECT_NE(text.find(stored ? "nodes a 2/8" : "nodes a 5/8"), std::string::npos) << text;
  }
}

TEST(Progress, ThePointsThatAreReadAreToldWhileThereAreNoTiles) {
  ProgressSnapshot now;
  now.phase = Phase::routing;
  now.elapsed_s = 1;
  now.points_routed = 4560;
  EXPECT_NE(progress_text({}, now).find("   4.56 k points   "), std::string::npos) << progress_text({}, now);
  now.phase = Phase::finishing;
  EXPECT_EQ(progress_text({}, now).find("points"), std::string::npos) << progress_text({}, now);
}

TEST(Progress, TheRateIsThatOfThePhase) {
  auto before = halfway();
  before.elapsed_s = 8;
  before.points_triangulated = 300;
  EXPECT_DOUBLE_EQ(points_per_second(before, halfway()), 100);
  EXPECT_EQ(points_per_second(halfway(), halfway()), 0);
}

TEST(Progress, ThePanelFitsTheTerminalHoweverNarrow) {
  for (const int columns : {1, 10, 40, 80, 200}) {
    for (const auto& line : progress_panel({}, halfway(), columns))
      EXPECT_LE(line.size(), static_cast<std::size_t>(columns));
  }
}

TEST(Progress, TheLineTellsPhaseTilesMessagesMemoryAndTheTimeLeft) {
  const auto text = progress_text({}, halfway());
  for (const auto* part : {"triangulating", "tiles 4/8", "in flight 2", "memory 1.00 GiB", "ETA "}) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  }
}

TEST(Progress, MoreProcessedThanSentIsNoneInFlight) {  // the two counters are read one after the other
  auto now = halfway();
  now.updates_processed = 9;
  EXPECT_EQ(nlohmann::json::parse(progress_json({}, now))["messages_in_flight"], 0);
}

std::string shown(ProgressStyle style) {
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::tmpfile(), &std::fclose);
  Progress progress;
  {
    ProgressDisplay display(progress, style, file.get());
    progress.phase = Phase::routing;
    while (display.elapsed_s() < 0.5) std::this_thread::yield();
  }
  std::string text(static_cast<std::size_t>(std::ftell(file.get())), '\0');
  std::rewind(file.get());
  EXPECT_EQ(std::fread(text.data(), 1, text.size(), file.get()), text.size());
  return text;
}

TEST(Progress, DisplaysShowAChangeOfPhaseInTheirStyle) {
  EXPECT_EQ(shown(ProgressStyle::none), "");
  EXPECT_NE(shown(ProgressStyle::lines).find("reading"), std::string::npos);
  EXPECT_EQ(nlohmann::json::parse(shown(ProgressStyle::json))["phase"], "routing");
  const auto panel = shown(ProgressStyle::terminal);
  EXPECT_NE(panel.find("reading"), std::string::npos);
  EXPECT_TRUE(panel.ends_with("\033[J"));  // taken away at the end
}

}  // namespace
}  // namespace tessera
