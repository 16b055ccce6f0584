// Jobs of several engines as one cluster: the same files, whoever works on them.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "actors/engine/engine.h"
#include "src/cluster/certs/certificates.h"
#include "tests/cluster/cluster_testing.h"

namespace tessera {
namespace {

TEST_F(ClusterTest, RunsAJobOnAllNodes) {
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

TEST_F(ClusterTest, RoutesAnInputOnAllNodes) {
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

// In 2D, of columns that have other names there, with ten points of different heights at each place.
TEST_F(ClusterTest, ReadsColumnsAndKeepsEqualPointsAsOneNodeDoes) {
  constexpr std::uint64_t rows = 400'000;
  const auto input = (folder_.path() / "survey.npy").string();
  {
    std::string header = "{'descr': '<f8', 'fortran_order': False, 'shape': (" + std::to_string(rows) + ", 4), }";
    header.resize(117, ' ');
    std::ofstream out(input, std::ios::binary);
    out.write("\x93NUMPY\x01\x00\x76\x00", 10);
    out << header << '\n';
    for (std::uint64_t i = 0; i < rows; ++i) {
      const std::uint64_t place = i * 7919 % (rows / 10);
      const double row[] = {double(i), double(place / 200), double(place % 200), double(i * 31 % 17)};
      out.write(reinterpret_cast<const char*>(row), sizeof row);
    }
  }
  for (const auto keep : {DuplicatePolicy::lowest, DuplicatePolicy::last}) {
    const CloudOptions wanted{.dimension = 2, .keep = keep, .columns = {"_", "y", "x", "z"}};
    const std::string name(name_of(keep));
    Progress progress, other;
    Engine alone(2, memory);
    const auto one = routed_by(alone, input, "one-" + name, progress, {}, wanted);
    ASSERT_TRUE(one) << one.error().where;
    const auto first = coordinator();
    const auto second = start(options("second"));
    wait_for("node second", "has joined");
    const auto many = routed_by(*first, input, "many-" + name, other, {}, wanted);
    ASSERT_TRUE(many) << many.error().where;
    EXPECT_GE(many.value().bundles.size(), 4U);
    expect_same(one.value(), many.value());
    EXPECT_EQ(run(*first, many.value()), run(alone, one.value()));
    std::uint64_t vertices = 0, other_heights = 0;
    for (std::uint32_t t = 0; t < many.value().partition.tiles(); ++t) {
      const auto tile = load_tile(many.value(), TileId{t}).value();
      vertices += tile.points.size();
      other_heights += tile.other_heights;
      for (const auto& [duplicate, kept] : tile.duplicates) {
        const std::uint64_t a = duplicate.value * 31 % 17, b = kept.value * 31 % 17;
        ASSERT_TRUE(keep == DuplicatePolicy::last ? kept > duplicate : b < a || (b == a && kept < duplicate));
      }
    }
    EXPECT_EQ(vertices, rows / 10);
    EXPECT_GT(other_heights, rows / 2);
    const std::lock_guard lock(mutex_);
    said_.clear();
  }
}

TEST_F(ClusterTest, RoutesWhileNodesComeAndGo) {
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
    std::optional<Result<RoutedCloud>> many;
    Progress with_guests;
    std::jthread routing([&] { many = routed_by(*first, input, name, with_guests); });
    while (with_guests.points_routed == 0 && with_guests.tiles_total == 0) std::this_thread::yield();
    guest.reset();
    routing.join();
    ASSERT_TRUE(*many) << many->error().where;
    expect_same(one.value(), many->value());
  }
}

TEST_F(ClusterTest, StopsRoutingAndTellsWhatIsWrongWithTheInput) {
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

TEST_F(ClusterTest, WaitsForANodeAndIsInterruptedMeanwhile) {
  const auto first = coordinator(false);
  const RoutedCloud cloud = routed("waiting");
  std::stop_source stop;
  Progress progress;
  stop.request_stop();
  const auto summary =
      first->run(cloud, cloud.folder.parent_path(), {.memory_bytes = memory}, progress, stop.get_token());
  ASSERT_FALSE(summary);
  EXPECT_EQ(summary.error().code, Errc::interrupted);
}

TEST_F(ClusterTest, RefusesOthersWithASentence) {
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

TEST_F(ClusterTest, IsFoundByNameAtWhicheverAddressItHas) {
  const auto first = coordinator();
  auto by_name = options("second");
  by_name.join = {{"localhost", first_.port}};
  const auto second = start(by_name);
  wait_for("node second", "has joined");
  auto nowhere = options("third");
  nowhere.join = {{"no.such.host.invalid", first_.port}};
  const auto third = start(nowhere);
  wait_for("no node of the cluster can be reached yet", "no.such.host.invalid: ");
}

// Whoever has a certificate of another authority is not spoken to.
TEST_F(ClusterTest, DoesNotSpeakToStrangers) {
  const auto first = coordinator();
  const auto foreign = folder_.path() / "foreign";
  ASSERT_TRUE(make_authority(foreign));
  ASSERT_TRUE(make_node(foreign, "spy"));
  auto spy = options("spy");
  spy.authority = authority_file(foreign);
  spy.certificate = node_certificate_file(foreign, "spy");
  spy.key = node_key_file(foreign, "spy");
  const auto engine = start(spy);
  // Both sides say why.
  wait_for("no node of the cluster can be reached", "the connection was closed before any message came");
  wait_for("the connection to 127.0.0.1:" + std::to_string(first_.port) + " is refused",
           "certificate 'all' is of another authority");
  const auto second = start(options("second"));
  wait_for("node second", "has joined");  // nor are the others disturbed
  EXPECT_EQ(first->nodes().size(), 2U);
}

// It has been valid when its process began. Both sides say what is wrong.
TEST_F(ClusterTest, BothSidesSayThatACertificateHasExpired) {
  const auto first = coordinator();
  const auto now = std::chrono::system_clock::now();
  ASSERT_TRUE(make_node(certs_, "old", {.days = 1, .now = now - std::chrono::hours(72)}));
  auto late = options("late");
  late.certificate = node_certificate_file(certs_, "old");
  late.key = node_key_file(certs_, "old");
  late.certificate_end_s =
      static_cast<std::uint64_t>(std::chrono::system_clock::to_time_t(now - std::chrono::hours(48)));
  const auto engine = start(late);
  wait_for("a connection from 127.0.0.1 is refused", "its certificate 'old' has expired on ");
  wait_for("no node of the cluster can be reached",
           "the certificate of this node has expired: " + late.certificate.string());
  EXPECT_EQ(first->nodes().size(), 1U);
}

}  // namespace
}  // namespace tessera
