// A job over a result, of two stages, on a cluster of four processes, of which some are killed in either stage.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "src/delaunay/run/settled_stages.h"
#include "tests/cluster/cluster_testing.h"
#include "tests/cluster/greatest_on_disk.h"
#include "tests/store/sample_result.h"

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
                                                                      scratch.string()});
    wait_for("node " + name, "has joined");
    return process;
  }
  static KindsOfStages kinds() { return {{kind_of_greatest, std::make_shared<const GreatestOnDisk>("first")}}; }
  std::unique_ptr<Engine> first() {
    auto own = options("first");
    own.coordinator = true;
    first_ = own.listen;
    own.join.clear();
    auto engine = Engine::join(1, memory, std::make_unique<Seat>(std::move(own)), kinds());
    EXPECT_TRUE(engine) << engine.error().where;
    return std::move(engine).value();
  }
  // Of twelve tiles.
  std::filesystem::path result() {
    const auto out = folder_.path() / "result";
    test::store_sample(out, test::sample_tiles(test::sample_points(test::Shape::uniform, 3, 4'000), 3, 12));
    return out;
  }
  ResultJob job(const std::filesystem::path& result, const std::string& name) {
    const auto run = folder_.path() / name;
    std::filesystem::create_directories(run);
    EXPECT_TRUE(write_whole(plan_file(run), std::string_view("the greatest of neighbours\n")));
    return {kind_of_greatest, result, run, {.threads = 2, .memory_bytes = memory}};
  }
  static void expect_right(const ResultJob& job) {
    const TileSource source = TileSource::open(job.result).value();
    ASSERT_EQ(source.tiles(), 12U);
    std::map<TileId, std::vector<TileId>> near;
    std::map<TileId, std::uint64_t> number;
    for (std::size_t i = 0; i < source.tiles(); ++i) {
      const TileId tile = source.entry(i).tile;
      near[tile] = touched(source, tile).value();
      number[tile] = number_of(tile);
    }
    for (std::uint32_t stage = 0; stage < 2; ++stage) {
      std::map<TileId, std::uint64_t> next = number;
      for (const auto& [tile, neighbours] : near) {
        for (const TileId one : neighbours) {
          next[tile] = std::max(next[tile], number.at(one));
          for (const TileId far : near.at(one)) next[tile] = std::max(next[tile], number.at(far));
        }
        const auto found = GreatestOnDisk::found(job.run, stage, tile);
        ASSERT_TRUE(found) << found.error().where;
        EXPECT_EQ(found.value(), next.at(tile)) << "tile " << tile.value << " in stage " << stage;
      }
      number = next;
    }
    EXPECT_EQ(settled_stages(job.run, 2).value(), 2U);
  }
};

void await(const std::filesystem::path& file) {
  while (!std::filesystem::exists(file)) std::this_thread::yield();
}

TEST_F(StagedCluster, OneProcessRunsBothStagesAndGoesOnWhereItEnded) {
  Engine engine(2, memory, kinds());
  const ResultJob job = this->job(result(), "one");
  for (const bool again : {false, true}) {  // the second time all is settled
    std::filesystem::remove(GreatestOnDisk::begun(job.run, 0, "first"));
    std::filesystem::remove(GreatestOnDisk::begun(job.run, 1, "first"));
    Progress progress;
    double done = 0;
    const auto status = engine.run(job, [&](double part) { done = part; }, progress, {});
    ASSERT_TRUE(status) << status.error().where;
    EXPECT_EQ(done, 1.0);
    expect_right(job);
    for (const std::uint32_t stage : {0U, 1U})
      EXPECT_EQ(std::filesystem::exists(GreatestOnDisk::begun(job.run, stage, "first")), !again);
  }
}

TEST_F(StagedCluster, AJobThatIsStoppedGoesOn) {
  Engine engine(2, memory, kinds());
  const ResultJob job = this->job(result(), "stopped");
  std::ofstream(GreatestOnDisk::hold(job.run, 1)) << "held\n";
  std::stop_source stop;
  Progress progress;
  std::jthread stopper([&] {
    await(GreatestOnDisk::begun(job.run, 1, "first"));
    stop.request_stop();
  });
  const auto stopped = engine.run(job, {}, progress, stop.get_token());
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, Errc::interrupted);
  EXPECT_EQ(settled_stages(job.run, 2).value(), 1U);
  std::filesystem::remove(GreatestOnDisk::hold(job.run, 1));
  std::filesystem::remove(GreatestOnDisk::begun(job.run, 0, "first"));
  ASSERT_TRUE(engine.run(job, {}, progress, {}));
  EXPECT_FALSE(std::filesystem::exists(GreatestOnDisk::begun(job.run, 0, "first")));
  expect_right(job);
}

TEST_F(StagedCluster, AKindThatNobodyKnowsIsRefused) {
  Engine engine(2, memory);
  Progress progress;
  const auto refused = engine.run(job(result(), "unknown"), {}, progress, {});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().where.find(kind_of_greatest), std::string::npos) << refused.error().where;
}

TEST_F(StagedCluster, LosesNothingWhenNodesAreKilledInEitherStage) {
  const auto coordinator = first();
  std::map<std::string, std::unique_ptr<Process>> nodes;
  for (const std::string name : {"second", "third", "fourth"}) nodes[name] = node(name);
  const auto result = this->result();
  for (int round = 0; round < 3; ++round) {
    SCOPED_TRACE(round);
    const ResultJob job = this->job(result, "round-" + std::to_string(round));
    for (const std::uint32_t stage : {0U, 1U}) std::ofstream(GreatestOnDisk::hold(job.run, stage)) << "held\n";
    Progress progress;
    std::optional<Status> status;
    std::jthread running([&] { status = coordinator->run(job, {}, progress, {}); });
    std::set<std::string> lost;
    const auto lose = [&](const std::string& name) {
      nodes[name]->kill();
      wait_for("node " + name, "is lost");
      lost.insert(name);
    };
    if (round == 1) {  // in the first stage, too: what it had begun begins on another
      await(GreatestOnDisk::begun(job.run, 0, "fourth"));
      lose("fourth");
    }
    std::filesystem::remove(GreatestOnDisk::hold(job.run, 0));
    await(GreatestOnDisk::begun(job.run, 1, "second"));
    lose("second");
    std::filesystem::remove(GreatestOnDisk::hold(job.run, 1));
    if (round == 2) lose("third");  // when some have come to the end, perhaps
    running.join();
    ASSERT_TRUE(*status) << status->error().where;
    expect_right(job);
    {
      const std::lock_guard lock(mutex_);
      said_.clear();
    }
    for (const std::string& name : lost) nodes[name] = node(name);
  }
}

}  // namespace
}  // namespace tessera::testing
