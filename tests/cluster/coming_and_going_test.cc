// Nodes that come, are lost, or leave in order while a job runs.
#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "actors/engine/engine.h"
#include "tests/cluster/cluster_testing.h"

namespace tessera {
namespace {

// Those that come while a job runs take part; one that goes is lost, and the others do its work.
TEST_F(ClusterTest, GoesOnWhileNodesComeAndGo) {
  const auto expected = alone();
  const auto first = coordinator();
  const RoutedCloud cloud = routed("changing");
  std::vector<std::uint64_t> got;
  std::jthread job([&] { got = run(*first, cloud); });
  for (int i = 0; i < 3; ++i) {
    const std::string name = "guest-" + std::to_string(i);
    auto guest = start(options(name));
    wait_for("node " + name, "has joined");
    guest.reset();
    wait_for("node " + name, "is lost");
  }
  job.join();
  EXPECT_EQ(got, expected);
}

// One node after the other leaves, and another process takes its place: what it had begun the others go on with.
TEST_F(ClusterTest, NothingBeginsAgainWhenNodesAreDrainedOrDepart) {
  const RoutedCloud cloud = routed("rolling", 150'000);
  Engine alone(2, memory);
  const auto expected = run(alone, routed("still", 150'000));
  const auto first = coordinator();
  std::map<std::string, std::unique_ptr<Engine>> nodes;
  for (const std::string name : {"second", "third"}) {
    nodes[name] = start(options(name));
    wait_for("node " + name, "has joined");
  }
  Progress progress;
  std::uint64_t handed = 0;
  progress.log = [&](const std::string& line) {
    const std::string words = "other nodes continue ";
    if (const auto at = line.find(words); at != std::string::npos) handed += std::stoul(line.substr(at + words.size()));
  };
  std::optional<Result<RunSummary>> summary;
  std::jthread job([&] {
    summary = first->run(cloud, cloud.folder.parent_path(), {.threads = 2, .memory_bytes = memory}, progress, {});
  });
  while (progress.tiles_triangulated == 0) std::this_thread::yield();
  for (const std::string name : {"second", "third"}) {
    if (name == "second") {
      EXPECT_TRUE(first->drain(name).value());
    } else {
      nodes[name]->depart();
    }
    wait_for("node " + name, "is drained");
    nodes[name] = start(options(name + "-anew"));
    wait_for("node " + name + "-anew", "has joined");
  }
  job.join();
  ASSERT_TRUE(*summary) << summary->error().where;
  const RunSummary& done = summary->value();
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(done.tiles.at(i).xxh3, expected[i]);
  EXPECT_EQ(done.exchange.tiles_again + done.exchange.nodes_lost, 0U);
  EXPECT_GT(handed, 0U);
}

// The only one may, if it wants to itself; and whoever finds no coordinator, if it has nothing.
TEST_F(ClusterTest, LetsANodeDepart) {
  auto expelled = [this](const std::string& name) {
    auto with = options(name);
    with.expelled = [log = with.log, name](const std::string& why, bool again) {
      log(name + (again ? " begins anew: it " : " ends: it ") + why);
    };
    return with;
  };
  const auto first = coordinator(false);
  const auto only = start(expelled("only"));
  wait_for("node only", "has joined");
  EXPECT_FALSE(first->drain("only"));
  EXPECT_FALSE(only->membership_status().leaves);
  only->depart();
  wait_for("only ends", "is drained");
  EXPECT_TRUE(only->membership_status().leaves);
  EXPECT_TRUE(first->nodes().empty());
  EXPECT_EQ(first->nodes_lost(), 0U);
  first_ = {"127.0.0.1", free_port()};
  const auto lonely = start(expelled("lonely"));
  wait_for("no node of the cluster can be reached", "127.0.0.1");
  lonely->depart();
  wait_for("lonely ends", "had no tiles that other nodes would continue");
}

}  // namespace
}  // namespace tessera
