// A second stage on a cluster of four processes, of which some are killed while it runs, and before.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>

#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/cluster/cluster_testing.h"
#include "tests/cluster/greatest_on_disk.h"

extern char** environ;

namespace tessera::testing {
namespace {

// A node in a process of its own, killed at the latest when this goes.
class Process {
 public:
  Process(std::vector<std::string> arguments) {
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    EXPECT_EQ(::pipe2(input_, O_CLOEXEC), 0);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, input_[0], 0);
    EXPECT_EQ(::posix_spawn(&id_, TESSERA_STAGED_NODE, &actions, nullptr, argv.data(), environ), 0);
    posix_spawn_file_actions_destroy(&actions);
    ::close(input_[0]);
  }
  ~Process() { kill(); }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  void kill() {
    if (id_ == 0) return;
    ::kill(id_, SIGKILL);
    ::waitpid(id_, nullptr, 0);
    ::close(input_[1]);
    id_ = 0;
  }

 private:
  int input_[2] = {-1, -1};
  pid_t id_ = 0;
};

class StagedCluster : public ClusterTest {
 protected:
  std::unique_ptr<Process> node(const std::string& name) {
    const auto scratch = folder_.path() / ("scratch-" + name);
    std::filesystem::create_directories(scratch);
    auto process = std::make_unique<Process>(std::vector<std::string>{"staged_node", name, std::to_string(free_port()),
                                                                      std::to_string(first_.port), certs_.string(),
                                                                      scratch.string(), results_.string()});
    wait_for("node " + name, "has joined");
    return process;
  }
  std::unique_ptr<Engine> first() {
    auto own = options("first");
    own.coordinator = true;
    first_ = own.listen;
    own.join.clear();
    stage_->name = "first";
    auto engine = Engine::join(1, memory, std::make_unique<Seat>(std::move(own)), {stage_});
    EXPECT_TRUE(engine) << engine.error().where;
    return std::move(engine).value();
  }
  void expect_right(const RunSummary& summary, const std::filesystem::path& out) {
    std::map<TileId, std::vector<TileId>> near;
    for (const TileEntry& tile : summary.tiles) near[tile.tile] = touched(out, tile.tile).value();
    for (const auto& [tile, neighbours] : near) {
      std::uint64_t expected = number_of(tile);
      for (const TileId one : neighbours) {
        expected = std::max(expected, number_of(one));
        for (const TileId far : near.at(one)) expected = std::max(expected, number_of(far));
      }
      std::ifstream file(stage_->result(tile));
      std::uint64_t found = 0;
      EXPECT_TRUE(file >> found) << "tile " << tile.value;
      EXPECT_EQ(found, expected) << "tile " << tile.value;
    }
  }

  bool some_began() const {
    for (const char* const name : {"first", "second", "third", "fourth"}) {
      if (std::filesystem::exists(stage_->begun(name))) return true;
    }
    return false;
  }

  const std::filesystem::path results_ = [this] {
    const auto folder = folder_.path() / "greatest";
    std::filesystem::create_directories(folder);
    return folder;
  }();
  std::shared_ptr<GreatestOnDisk> stage_ = std::make_shared<GreatestOnDisk>(results_);
};

void await(const std::filesystem::path& file) {
  while (!std::filesystem::exists(file)) std::this_thread::yield();
}

TEST_F(StagedCluster, OneProcessRunsBothStagesAndGoesOnWhereItEnded) {
  const RoutedRun cloud = routed("one");
  const auto out = cloud.folder.parent_path();
  Engine engine(2, memory, {stage_});
  for (const bool again : {false, true}) {  // the second time all is settled
    Progress progress;
    const auto summary = engine.run(cloud, out, {.threads = 2, .memory_bytes = memory}, progress, {});
    ASSERT_TRUE(summary) << summary.error().where;
    EXPECT_EQ(summary.value().tiles.size(), 12U);
    EXPECT_EQ(summary.value().exchange.waves == 0, again);
    expect_right(summary.value(), out);
  }
  EXPECT_EQ(settled_stages(cloud.folder, 2).value(), 2U);
}

TEST_F(StagedCluster, LosesNothingWhenNodesAreKilledInEitherStage) {
  const auto expected = alone();
  const auto coordinator = first();
  std::map<std::string, std::unique_ptr<Process>> nodes;
  for (const std::string name : {"second", "third", "fourth"}) nodes[name] = node(name);
  for (int round = 0; round < 3; ++round) {
    SCOPED_TRACE(round);
    const std::string name = "round-" + std::to_string(round);
    const RoutedRun cloud = routed(name);
    const auto out = cloud.folder.parent_path();
    for (const auto& entry : std::filesystem::directory_iterator(results_)) std::filesystem::remove(entry);
    std::ofstream(stage_->hold()) << "held\n";
    Progress progress;
    std::optional<Result<RunSummary>> summary;
    std::jthread job(
        [&] { summary = coordinator->run(cloud, out, {.threads = 2, .memory_bytes = memory}, progress, {}); });
    if (round == 1) {  // in the first stage, too, but for a thread that sleeps through it: the second counts anew
      while (progress.tiles_triangulated == 0 && !some_began()) std::this_thread::yield();
      nodes["fourth"]->kill();
      wait_for("node fourth", "is lost");
    }
    await(stage_->begun("second"));
    nodes["second"]->kill();
    wait_for("node second", "is lost");
    std::filesystem::remove(stage_->hold());
    if (round == 2) {  // when some have come to the end, perhaps
      nodes["third"]->kill();
      wait_for("node third", "is lost");
    }
    job.join();
    ASSERT_TRUE(*summary) << summary->error().where;
    std::vector<std::uint64_t> sums;
    for (const TileEntry& tile : summary->value().tiles) sums.push_back(tile.xxh3);
    EXPECT_EQ(sums, expected);
    EXPECT_GT(summary->value().exchange.nodes_lost, 0U);
    expect_right(summary->value(), out);
    {
      const std::lock_guard lock(mutex_);
      said_.clear();
    }
    for (const std::string lost : {"second", "third", "fourth"}) {
      if (lost == "second" || (lost == "fourth" && round == 1)) nodes[lost] = node(lost);
    }
  }
}

}  // namespace
}  // namespace tessera::testing
