#include "src/base/phases.h"

#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

namespace tessera {
namespace {

// Manifests, metrics and clients of other releases have them.
TEST(Phases, KeepTheirNamesAndTheirOrder) {
  std::vector<std::string> names;
  for (const PhaseRow& row : phase_table) names.emplace_back(row.name);
  EXPECT_EQ(names, (std::vector<std::string>{"planning", "routing", "triangulating", "splaying", "collecting",
                                             "finishing", "done"}));
}

TEST(Phases, AreFoundByName) {
  for (const PhaseRow& row : phase_table) EXPECT_EQ(phase_named(name_of(row.phase)), row.phase);
  EXPECT_EQ(phase_named("cutting"), std::nullopt);
  EXPECT_EQ(phase_named(""), std::nullopt);
}

TEST(Phases, HaveWordsOfTheirOwn) {
  std::set<std::string> words;
  for (const PhaseRow& row : phase_table) words.insert(row.label);
  EXPECT_EQ(words.size(), phase_table.size());
}

TEST(Phases, ShareTheTimeOfAJob) {
  double all = 0;
  for (const PhaseRow& row : phase_table) all += row.share;
  EXPECT_NEAR(all, 1, 1e-12);
}

TEST(Phases, OfAProgramBeginExchangeAndStore) {
  std::set<ProgramKind> programs;
  for (const PhaseRow& row : phase_table) {
    EXPECT_EQ(row.program == ProgramKind::none, row.step == StageStep::none) << row.name;
    if (row.program != ProgramKind::none) programs.insert(row.program);
  }
  EXPECT_FALSE(programs.empty());
  for (const ProgramKind program : programs) {
    const Phase begin = phase_of(program, StageStep::begin), exchange = phase_of(program, StageStep::exchange),
                store = phase_of(program, StageStep::store);
    EXPECT_LT(begin, exchange);
    EXPECT_LT(exchange, store);
    EXPECT_TRUE(row_of(exchange).exchanges);
    EXPECT_TRUE(row_of(store).settled);
  }
}

TEST(Phases, ExchangeInAProgramAloneAndUntilAllIsSettled) {
  for (const PhaseRow& row : phase_table)
    EXPECT_FALSE(row.exchanges && (row.settled || row.program == ProgramKind::none)) << row.name;
}

TEST(Phases, ThatTheReportShowsHaveAColourOnLightAndOnDarkPaper) {
  for (const PhaseRow& row : phase_table) EXPECT_EQ(row.colour == nullptr, row.dark_colour == nullptr) << row.name;
}

}  // namespace
}  // namespace tessera
