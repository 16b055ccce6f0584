// Engines of several processes as one cluster, over TLS on the loopback: the same files, whoever works on them.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cmath>
#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "actors/cluster/seat.h"
#include "actors/engine/engine.h"
#include "src/certs/certificates.h"
#include "src/files/names.h"
#include "src/files/temporary.h"
#include "src/generate/generate.h"
#include "src/io/npy/array_source.h"
#include "src/reference/clouds.h"

namespace tessera {
namespace {

constexpr std::uint64_t memory = std::uint64_t{256} << 20;

std::uint16_t free_port() {
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof address;
  EXPECT_EQ(::bind(socket, reinterpret_cast<const sockaddr*>(&address), length), 0);
  EXPECT_EQ(::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &length), 0);
  ::close(socket);
  return ntohs(address.sin_port);
}

class Cluster : public ::testing::Test {
 protected:
  Cluster() {
    EXPECT_TRUE(make_authority(certs_));
    EXPECT_TRUE(make_node(certs_, "all"));
  }

  ClusterOptions options(const std::string& name) {
    ClusterOptions options;
    options.node_name = name;
    options.listen = {"127.0.0.1", free_port()};
    options.coordinator = false;
    options.join = {first_};
    options.authority = authority_file(certs_);
    options.certificate = node_certificate_file(certs_, "all");
    options.key = node_key_file(certs_, "all");
    options.scratch = folder_.path() / ("scratch-" + name);
    std::filesystem::create_directories(options.scratch);
    options.log = [this](const std::string& line) {
      const std::lock_guard lock(mutex_);
      said_.insert(line);
      heard_.notify_all();
    };
    return options;
  }

  std::unique_ptr<Engine> coordinator(bool also_node = true) {
    auto first = options("first");
    first.coordinator = true;
    first.node = also_node;
    first_ = first.listen;
    first.join.clear();
    return start(std::move(first));
  }

  static std::unique_ptr<Engine> start(ClusterOptions options) {
    auto engine = Engine::join(1, memory, std::make_unique<Seat>(std::move(options)));
    EXPECT_TRUE(engine) << engine.error().where;
    return std::move(engine).value();
  }

  // Until somebody has logged a line with all of this in it.
  void wait_for(const std::string& a, const std::string& b) {
    std::unique_lock lock(mutex_);
    heard_.wait(lock, [&] {
      for (const std::string& line : said_) {
        if (line.find(a) != std::string::npos && line.find(b) != std::string::npos) return true;
      }
      return false;
    });
  }

  RoutedRun routed(const std::string& name, std::size_t points = 20'000) {
    const auto coordinates = coordinates_of(make_cloud("uniform", 3, points, 1), 3);
    const auto out = folder_.path() / name;
    std::filesystem::create_directory(out);
    Progress progress;
    const Cloud cloud = Cloud::open_source(array_source("cloud", coordinates, 3), {.dimension = 3}).value();
    return route(cloud, run_folder(out), {.tiles = 12}, progress, {}).value();
  }

  // A file that all see, of more points than one stretch has.
  std::string file() {
    const auto path = folder_.path() / "cloud.npy";
    EXPECT_TRUE(generate({.points = 600'000}, path));
    return path.string();
  }
  Result<RoutedRun> routed_by(const Engine& engine, const std::string& file, const std::string& name,
                              Progress& progress, const std::stop_token& stop = {}) {
    const auto out = folder_.path() / name;
    std::filesystem::create_directory(out);
    BOOST_OUTCOME_TRY(cloud, Cloud::open({file}, {.dimension = 3}));
    const auto router = engine.router(memory);
    return route(cloud, run_folder(out), {.tiles = 12}, progress, stop, router.get());
  }

  // But for who has routed what.
  static void expect_same(const RoutedRun& a, const RoutedRun& b) {
    EXPECT_EQ(a.tile_bounds, b.tile_bounds);
    EXPECT_EQ(a.seeds, b.seeds);
    EXPECT_EQ(a.counts.read, b.counts.read);
    for (std::uint32_t t = 0; t < a.partition.tiles(); ++t) {
      const auto in_a = load_tile(a, TileId{t}), in_b = load_tile(b, TileId{t});
      ASSERT_TRUE(in_a && in_b) << (in_a ? in_b : in_a).error().where;
      EXPECT_EQ(in_a.value().points, in_b.value().points);
      EXPECT_EQ(in_a.value().ids, in_b.value().ids);
    }
  }

  static std::vector<std::uint64_t> run(Engine& engine, const RoutedRun& run) {
    Progress progress;
    const auto summary =
        engine.run(run, run.folder.parent_path(), {.threads = 2, .memory_bytes = memory}, progress, {});
    EXPECT_TRUE(summary) << summary.error().where;
    std::vector<std::uint64_t> sums;
    if (!summary) return sums;
    for (const TileEntry& tile : summary.value().tiles) sums.push_back(tile.xxh3);
    return sums;
  }

  std::vector<std::uint64_t> alone() {
    Engine engine(2, memory);
    return run(engine, routed("alone"));
  }

  TemporaryFolder folder_ = TemporaryFolder::make().value();
  const std::filesystem::path certs_ = folder_.path() / "certs";
  HostPort first_;
  std::mutex mutex_;
  std::condition_variable heard_;
  std::set<std::string> said_;
};

TEST_F(Cluster, RunsAJobOnAllNodes) {
  const auto expected = alone();
  for (const bool also_node : {true, false}) {
    const auto first = coordinator(also_node);
    const auto second = start(options("second"));
    const auto third = start(options("third"));
    wait_for("node second", "has joined");
    wait_for("node third", "has joined");
    EXPECT_EQ(first->nodes().size(), also_node ? 3U : 2U);
    EXPECT_EQ(run(*first, routed(also_node ? "three" : "two")), expected);
    const std::lock_guard lock(mutex_);
    said_.clear();
  }
}

// Those that come while a job runs take part; one that goes is lost, and the others do its work.
TEST_F(Cluster, GoesOnWhileNodesComeAndGo) {
  const auto expected = alone();
  const auto first = coordinator();
  const RoutedRun cloud = routed("changing");
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
TEST_F(Cluster, NothingBeginsAgainWhenNodesAreDrainedOrDepart) {
  const RoutedRun cloud = routed("rolling", 150'000);
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
    const std::string words = "others go on with ";
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
TEST_F(Cluster, LetsANodeDepart) {
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
  EXPECT_FALSE(only->place().leaves);
  only->depart();
  wait_for("only ends", "is drained");
  EXPECT_TRUE(only->place().leaves);
  EXPECT_TRUE(first->nodes().empty());
  EXPECT_EQ(first->nodes_lost(), 0U);
  first_ = {"127.0.0.1", free_port()};
  const auto lonely = start(expelled("lonely"));
  wait_for("nobody of the cluster is reached", "127.0.0.1");
  lonely->depart();
  wait_for("lonely ends", "had nothing that others would go on with");
}

TEST_F(Cluster, RoutesAnInputOnAllNodes) {
  const auto input = file();
  Progress progress, other;
  const Engine alone(2, memory);
  const auto one = routed_by(alone, input, "one", progress);
  ASSERT_TRUE(one) << one.error().where;
  for (const bool also_node : {true, false}) {
    const auto first = coordinator(also_node);
    const auto second = start(options("second"));
    wait_for("node second", "has joined");
    const auto many = routed_by(*first, input, also_node ? "two" : "single", other);
    ASSERT_TRUE(many) << many.error().where;
    EXPECT_GE(many.value().bundles.size(), 4U);
    expect_same(one.value(), many.value());
    EXPECT_EQ(other.points_routed, 600'000U);
    EXPECT_EQ(run(*first, many.value()).size(), 12U);
    const std::lock_guard lock(mutex_);
    said_.clear();
  }
}

TEST_F(Cluster, RoutesWhileNodesComeAndGo) {
  const auto input = file();
  Progress progress;
  const Engine alone(2, memory);
  const auto one = routed_by(alone, input, "one", progress);
  ASSERT_TRUE(one) << one.error().where;
  const auto first = coordinator();
  for (int i = 0; i < 4; ++i) {
    const std::string name = "guest-" + std::to_string(i);
    auto guest = start(options(name));
    wait_for("node " + name, "has joined");
    std::optional<Result<RoutedRun>> many;
    Progress with_guests;
    std::jthread routing([&] { many = routed_by(*first, input, name, with_guests); });
    while (with_guests.points_routed == 0 && with_guests.tiles_total == 0) std::this_thread::yield();
    guest.reset();
    routing.join();
    ASSERT_TRUE(*many) << many->error().where;
    expect_same(one.value(), many->value());
  }
}

TEST_F(Cluster, StopsRoutingAndTellsWhatIsWrongWithTheInput) {
  const auto first = coordinator();
  const auto second = start(options("second"));
  wait_for("node second", "has joined");
  const auto input = file();
  Progress progress;
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(routed_by(*first, input, "stopped", progress, stop.get_token()).error().code, Errc::interrupted);
  // A point that is not finite, in the last stretch.
  {
    std::fstream damaged(input, std::ios::binary | std::ios::in | std::ios::out);
    damaged.seekp(-8, std::ios::end);
    const double nan = std::nan("");
    damaged.write(reinterpret_cast<const char*>(&nan), sizeof nan);
  }
  const auto refused = routed_by(*first, input, "damaged", progress);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Errc::bad_input);
  EXPECT_NE(refused.error().where.find("row 599999"), std::string::npos) << refused.error().where;
}

TEST_F(Cluster, WaitsForANodeAndIsInterruptedMeanwhile) {
  const auto first = coordinator(false);
  const RoutedRun cloud = routed("waiting");
  std::stop_source stop;
  Progress progress;
  stop.request_stop();
  const auto summary =
      first->run(cloud, cloud.folder.parent_path(), {.memory_bytes = memory}, progress, stop.get_token());
  ASSERT_FALSE(summary);
  EXPECT_EQ(summary.error().code, Errc::interrupted);
}

TEST_F(Cluster, RefusesOthersWithASentence) {
  const auto first = coordinator();
  auto other = options("other-cluster");
  other.name = "another";
  const auto a = start(other);
  wait_for("refused", "it belongs to the cluster 'another'");
  auto elsewhere = options("elsewhere");
  elsewhere.shared = "another folder";
  const auto b = start(elsewhere);
  wait_for("refused", "data folder is not the coordinator's");
  EXPECT_EQ(first->nodes().size(), 1U);
}

TEST_F(Cluster, IsFoundByNameAtWhicheverAddressItHas) {
  const auto first = coordinator();
  auto by_name = options("second");
  by_name.join = {{"localhost", first_.port}};
  const auto second = start(by_name);
  wait_for("node second", "has joined");
  auto nowhere = options("third");
  nowhere.join = {{"no.such.host.invalid", first_.port}};
  const auto third = start(nowhere);
  wait_for("nobody of the cluster is reached yet", "no.such.host.invalid: ");
}

// Whoever has a certificate of another authority is not spoken to.
TEST_F(Cluster, DoesNotSpeakToStrangers) {
  const auto first = coordinator();
  const auto foreign = folder_.path() / "foreign";
  ASSERT_TRUE(make_authority(foreign));
  ASSERT_TRUE(make_node(foreign, "spy"));
  auto spy = options("spy");
  spy.authority = authority_file(foreign);
  spy.certificate = node_certificate_file(foreign, "spy");
  spy.key = node_key_file(foreign, "spy");
  const auto engine = start(spy);
  wait_for("nobody of the cluster is reached", "disconnect_during_handshake");
  const auto second = start(options("second"));
  wait_for("node second", "has joined");  // nor are the others disturbed
  EXPECT_EQ(first->nodes().size(), 2U);
}

}  // namespace
}  // namespace tessera
