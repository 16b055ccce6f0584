// What watchers are told of the tiles of a job.
#include <set>

#include "tests/service/service_testing.h"

namespace tessera::service::testing {
namespace {

using Tiles = ServiceTest;

proto::Inputs in_tiles(const std::string& input, const std::string& output, std::uint32_t tiles) {
  proto::Inputs inputs;
  inputs.mutable_triangulate()->add_inputs(input);
  inputs.mutable_triangulate()->set_output(output);
  inputs.mutable_triangulate()->set_tiles(tiles);
  return inputs;
}

// The children of all rows: every row but the first, and every tile, once.
void expect_a_tree(const proto::TileLayout& layout, int tiles) {
  ASSERT_EQ(layout.axis_size(), tiles - 1);
  ASSERT_EQ(layout.place_size(), tiles - 1);
  ASSERT_EQ(layout.below_size(), tiles - 1);
  ASSERT_EQ(layout.above_size(), tiles - 1);
  std::multiset<std::int32_t> children(layout.below().begin(), layout.below().end());
  children.insert(layout.above().begin(), layout.above().end());
  for (int row = 1; row < tiles - 1; ++row) EXPECT_EQ(children.count(row), 1U);
  for (int tile = 0; tile < tiles; ++tile) EXPECT_EQ(children.count(-1 - tile), 1U);
}

TEST_F(Tiles, AreToldWhileAJobRunsAndAfterwards) {
  make_cloud("a.npy", 400'000);
  open();
  const auto id = submit(in_tiles("a.npy", "block", 40));
  const auto seen = wait(id, [&](const auto& now) { return now.tiles().triangulated() > 0 || now.progress() == 100; });
  if (seen.status() == "running") {
    const auto running = service->jobs().tiles(id, true);
    ASSERT_TRUE(running) << running.error().detail();
    EXPECT_EQ(running.value().stages().size(), 40U);
    EXPECT_EQ(running.value().stages().find_first_not_of("wtsqd"), std::string::npos);
    EXPECT_NE(running.value().stages(), std::string(40, 'w'));
    EXPECT_GT(running.value().elapsed_s(), 0);
    EXPECT_LE(running.value().busy_s(), running.value().elapsed_s());
    for (const double threads : running.value().busy_threads()) EXPECT_LE(threads, 2.001);
    expect_a_tree(running.value().layout(), 40);
  }
  ASSERT_EQ(ended(id).status(), "successful");
  const auto stored = service->jobs().tiles(id, true);
  ASSERT_TRUE(stored) << stored.error().detail();
  EXPECT_EQ(stored.value().stages(), std::string(40, 'd'));
  EXPECT_EQ(stored.value().layout().bounds_size(), 6);
  expect_a_tree(stored.value().layout(), 40);
  EXPECT_FALSE(service->jobs().tiles(id, false).value().has_layout());
}

TEST_F(Tiles, ExchangeMailWhileAJobSplaysAndNoneAtItsEnd) {
  make_cloud("a.npy", 400'000);
  open();
  const auto id = submit(in_tiles("a.npy", "block", 300));
  proto::JobTiles seen;
  wait(id, [&](const auto& now) {
    const auto told = service->jobs().tiles(id, false);
    if (told && told.value().has_mail()) seen = told.value();
    return seen.has_mail() || now.progress() == 100;
  });
  ASSERT_EQ(ended(id).status(), "successful");
  const auto stored = service->jobs().tiles(id, true).value();
  EXPECT_FALSE(stored.has_mail());
  const proto::TileMail& mail = seen.mail();
  ASSERT_GT(mail.points_size(), 0) << "300 tiles that exchange points are asked how far they are at every event";
  ASSERT_LE(mail.points_size(), 128);
  ASSERT_EQ(mail.from_size(), mail.points_size());
  ASSERT_EQ(mail.to_size(), mail.points_size());
  for (int arc = 0; arc < mail.points_size(); ++arc) {
    EXPECT_NE(mail.from(arc), mail.to(arc));
    EXPECT_GT(mail.points(arc), 0U);
    if (arc > 0) {
      EXPECT_LE(mail.points(arc), mail.points(arc - 1));
    }
    for (const int part : {mail.from(arc), mail.to(arc)}) {
      EXPECT_LT(part, stored.layout().axis_size());
      EXPECT_GE(part, -300);
    }
  }
  EXPECT_LT(mail.ByteSizeLong(), 4096U);
}

TEST_F(Tiles, OfOneTileAndOfARandomPartitionHaveNoPlanes) {
  make_cloud("a.xyz", 2000);
  open();
  const auto one = submit(in_tiles("a.xyz", "one", 1));
  ASSERT_EQ(ended(one).status(), "successful");
  EXPECT_EQ(service->jobs().tiles(one, true).value().stages(), "d");
  auto inputs = in_tiles("a.xyz", "scattered", 5);
  inputs.mutable_triangulate()->set_partition("random");
  const auto scattered = submit(inputs);
  ASSERT_EQ(ended(scattered).status(), "successful");
  const auto told = service->jobs().tiles(scattered, true);
  ASSERT_TRUE(told) << told.error().detail();
  EXPECT_EQ(told.value().stages(), "ddddd");
  EXPECT_EQ(told.value().layout().axis_size(), 0);
}

TEST_F(Tiles, OfAJobThatWaitsOrWasStoppedAreNotTold) {
  make_cloud("a.npy", 400'000);
  open();
  const auto id = submit(in_tiles("a.npy", "block", 40));
  ASSERT_TRUE(service->jobs().dismiss(id, alice));
  wait(id, [](const auto& now) { return now.status() != "running" && now.status() != "accepted"; });
  const auto told = service->jobs().tiles(id, true);
  ASSERT_TRUE(told) << told.error().detail();
  EXPECT_EQ(told.value().job_id(), id);
  EXPECT_EQ(told.value().stages(), "");
}

TEST_F(Tiles, ThatThereAreNotAreAProblem) {
  make_cloud("a.xyz", 1000);
  open();
  EXPECT_EQ(service->jobs().tiles("none", false).error().status(), 404);
  const auto id = submit(triangulate("a.xyz", "block"));
  ASSERT_EQ(ended(id).status(), "successful");
  const auto proof = submit(verify("block"));
  EXPECT_EQ(service->jobs().tiles(proof, false).error().status(), 404);
  ended(proof);
  ASSERT_TRUE(service->results().remove("block", alice));
  EXPECT_EQ(service->jobs().tiles(id, false).error().status(), 410);
}

}  // namespace
}  // namespace tessera::service::testing
