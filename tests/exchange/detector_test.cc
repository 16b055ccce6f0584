#include "src/exchange/detector.h"

#include <gtest/gtest.h>

#include <random>
#include <set>
#include <utility>
#include <vector>

namespace tessera {
namespace {

using Verdict = QuiescenceDetector::Verdict;

// Nodes 0, 1, ...
std::set<NodeId> first(std::uint32_t nodes) {
  std::set<NodeId> all;
  for (std::uint32_t n = 0; n < nodes; ++n) all.insert(NodeId{n});
  return all;
}

// All of them.
Verdict notices(QuiescenceDetector& d, std::uint32_t nodes) {
  Verdict last = Verdict::wait;
  for (const NodeId node : first(nodes)) {
    EXPECT_EQ(last, Verdict::wait);
    last = d.notice(node);
  }
  return last;
}

TEST(Detector, AsksTheNodesThatThereAreAndForgetsWhatOthersSaid) {
  QuiescenceDetector d(first(3));
  EXPECT_EQ(notices(d, 3), Verdict::probe);
  for (const NodeId node : first(3)) d.answer(Wave{1}, node, true, {1, 1});
  EXPECT_EQ(d.wave(), Wave{2}) << "could be quiet: a second wave";
  d.restart({NodeId{0}, NodeId{7}});
  EXPECT_EQ(d.answer(Wave{2}, NodeId{0}, true, {1, 1}), Verdict::wait) << "nobody has been asked since";
  EXPECT_EQ(d.look(), Verdict::wait) << "it has not heard of node 7";
  EXPECT_EQ(d.notice(NodeId{2}), Verdict::wait) << "it is not there any more";
  EXPECT_EQ(d.notice(NodeId{7}), Verdict::probe);
  EXPECT_EQ(d.wave(), Wave{3});
  EXPECT_EQ(d.answer(Wave{3}, NodeId{0}, true, {3, 3}), Verdict::wait);
  EXPECT_EQ(d.answer(Wave{3}, NodeId{1}, true, {0, 0}), Verdict::wait) << "it is not there any more";
  EXPECT_EQ(d.answer(Wave{3}, NodeId{7}, true, {0, 0}), Verdict::probe) << "the wave before the restart does not count";
  EXPECT_EQ(d.answer(Wave{4}, NodeId{7}, true, {0, 0}), Verdict::wait);
  EXPECT_EQ(d.answer(Wave{4}, NodeId{0}, true, {3, 3}), Verdict::quiet);
}

TEST(Detector, AWaveBeginsWhenAllHaveSaidThatTheyAreIdle) {
  QuiescenceDetector d(first(3));
  EXPECT_EQ(d.notice({1}), Verdict::wait);
  EXPECT_EQ(d.notice({1}), Verdict::wait);
  EXPECT_EQ(d.notice({0}), Verdict::wait);
  EXPECT_EQ(d.notice({2}), Verdict::probe);
  EXPECT_EQ(d.wave(), Wave{1});
  d.restart(first(2));
  EXPECT_EQ(d.look(), Verdict::probe) << "those that are left have said so";
  d.restart_busy(first(2));
  EXPECT_EQ(d.look(), Verdict::wait);
  EXPECT_EQ(notices(d, 2), Verdict::probe);
}

TEST(Detector, NobodyIsNotAskedAndNotQuiet) {
  QuiescenceDetector d({});
  EXPECT_EQ(d.look(), Verdict::wait);
  EXPECT_EQ(d.notice({0}), Verdict::wait);
}

TEST(Detector, BelievesOnlyTwoEqualWaves) {
  QuiescenceDetector d(first(2));
  EXPECT_EQ(notices(d, 2), Verdict::probe);
  EXPECT_EQ(d.answer(Wave{1}, {0}, true, {3, 1}), Verdict::wait);
  EXPECT_EQ(d.answer(Wave{1}, {1}, true, {1, 3}), Verdict::probe);
  EXPECT_EQ(d.answer(Wave{2}, {0}, true, {3, 1}), Verdict::wait);
  EXPECT_EQ(d.answer(Wave{2}, {1}, true, {1, 3}), Verdict::quiet);
}

TEST(Detector, SumsThatAgreeOnlyWithinAWaveAreNotEnough) {
  QuiescenceDetector d(first(1));
  d.notice({0});
  EXPECT_EQ(d.answer(Wave{1}, {0}, true, {3, 3}), Verdict::probe);
  EXPECT_EQ(d.answer(Wave{2}, {0}, true, {4, 4}), Verdict::probe);  // something happened between the waves: again
  EXPECT_EQ(d.answer(Wave{3}, {0}, true, {4, 4}), Verdict::quiet);
}

TEST(Detector, ABusyNodeOrAMessageOnItsWayEndsTheWave) {
  QuiescenceDetector d(first(2));
  notices(d, 2);
  d.answer(Wave{1}, {0}, false, {1, 1});
  EXPECT_EQ(d.answer(Wave{1}, {1}, true, {0, 0}), Verdict::wait);
  EXPECT_EQ(d.notice({1}), Verdict::wait) << "the other one is busy";
  EXPECT_EQ(d.notice({0}), Verdict::probe);
  d.answer(Wave{2}, {0}, true, {2, 1});
  EXPECT_EQ(d.answer(Wave{2}, {1}, true, {0, 0}), Verdict::wait);
  EXPECT_EQ(d.notice({1}), Verdict::probe) << "all are idle, and one was not in between";
}

TEST(Detector, ANoticeDuringAWaveStartsAnotherOne) {
  QuiescenceDetector d(first(2));
  notices(d, 2);
  EXPECT_EQ(d.answer(Wave{1}, {0}, false, {1, 0}), Verdict::wait);
  EXPECT_EQ(d.notice({0}), Verdict::wait) << "it was busy when it answered, and is not any more";
  EXPECT_EQ(d.answer(Wave{1}, {1}, true, {0, 1}), Verdict::probe);
}

TEST(Detector, AnswersToOldWavesAndSecondAnswersAreIgnored) {
  QuiescenceDetector d(first(2));
  notices(d, 2);
  EXPECT_EQ(d.answer(Wave{0}, {0}, true, {0, 0}), Verdict::wait);
  EXPECT_EQ(d.answer(Wave{1}, {0}, true, {0, 0}), Verdict::wait);
  EXPECT_EQ(d.answer(Wave{1}, {0}, true, {0, 0}), Verdict::wait);
  EXPECT_EQ(d.answer(Wave{1}, {7}, true, {0, 0}), Verdict::wait);
  EXPECT_EQ(d.answer(Wave{1}, {1}, true, {0, 0}), Verdict::probe);
}

// Nodes that send, receive and work at random, asked at random moments, and that say once after each answer that they
// have become idle: quiet is never said while a message is on its way or a node is busy, and always in the end.
TEST(Detector, QuietIsTrueForRandomHistories) {
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    std::mt19937_64 rng(seed);
    const std::uint32_t nodes = 1 + static_cast<std::uint32_t>(rng() % 5);
    struct Node {
      Totals totals;
      std::uint64_t work = 0;  // messages to process
      bool asked = false, told = false;
    };
    std::vector<Node> node(nodes);
    std::vector<std::uint32_t> on_the_way;
    std::uint64_t budget = rng() % 60;  // messages still to be caused
    node[0].work = 1;
    node[0].totals.sent = 1;  // the job itself
    QuiescenceDetector d(first(nodes));
    const auto tell = [&](Node& idle) {
      return std::exchange(idle.told, true) ? Verdict::wait
                                            : d.notice({static_cast<std::uint32_t>(&idle - node.data())});
    };
    for (Node& idle : node) {
      if (idle.work == 0) tell(idle);
    }
    bool quiet = false;
    for (int steps = 0; !quiet && steps < 100000; ++steps) {
      Verdict verdict = Verdict::wait;
      Node& n = node[rng() % nodes];
      switch (rng() % 4) {
        case 0:
          if (!on_the_way.empty()) {
            std::swap(on_the_way[rng() % on_the_way.size()], on_the_way.back());
            ++node[on_the_way.back()].work;
            on_the_way.pop_back();
          }
          break;
        case 1:
          if (n.work > 0) {
            for (std::uint64_t k = rng() % 3; k > 0 && budget > 0; --k, --budget) {
              on_the_way.push_back(static_cast<std::uint32_t>(rng() % nodes));
              ++n.totals.sent;
            }
            --n.work;
            ++n.totals.processed;
            if (n.work == 0) verdict = tell(n);
          }
          break;
        default:
          if (n.asked) {
            n.asked = n.told = false;
            verdict = d.answer(d.wave(), NodeId{static_cast<std::uint32_t>(&n - node.data())}, n.work == 0, n.totals);
          }
      }
      if (verdict == Verdict::probe) {
        for (Node& x : node) x.asked = true;
      }
      if (verdict == Verdict::quiet) {
        quiet = true;
        EXPECT_TRUE(on_the_way.empty()) << "seed " << seed;
        for (const Node& x : node) EXPECT_EQ(x.work, 0u) << "seed " << seed;
      }
    }
    EXPECT_TRUE(quiet) << "seed " << seed;
  }
}

TEST(PeerCounters, ForgettingAnIncarnationRemovesItFromTheSums) {
  PeerCounters counters;
  counters.add_sent({TileId{1}, 0});
  counters.add_sent({TileId{1}, 1});
  counters.add_processed({TileId{2}, 0});
  EXPECT_EQ(counters.totals(), (Totals{2, 1}));
  counters.forget_if([](TileIncarnation peer) { return peer == TileIncarnation{TileId{1}, 0}; });
  EXPECT_EQ(counters.totals(), (Totals{1, 1}));
}

}  // namespace
}  // namespace tessera
