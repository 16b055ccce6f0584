// write_heights(): the copies are tested in tests/input and tests/apps.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>

#include "src/base/files/temporary.h"
#include "src/input/generate/generate.h"
#include "tests/api/api_testing.h"

namespace tessera {
namespace {

using testing::failure_of;

class Heights : public ::testing::Test {
 protected:
  Heights() {
    EXPECT_TRUE(generate({.points = 400, .dimension = 2}, cloud()));
    triangulate({cloud()}, TriangulationOptions().dimension(2).folder(ground()));
  }
  std::string cloud() const { return (folder_.value().path() / "cloud.las").string(); }
  std::filesystem::path ground() const { return folder_.value().path() / "ground"; }
  std::filesystem::path out() const { return folder_.value().path() / "out"; }

 private:
  Result<TemporaryFolder> folder_ = TemporaryFolder::make();
};

TEST_F(Heights, AreADimensionOfCopies) {
  const auto made = write_heights({cloud()}, out(), HeightsRequest().ground(ground()).format("laz").threads(2));
  ASSERT_EQ(made.size(), 1u);
  EXPECT_EQ(made[0].input, cloud());
  EXPECT_EQ(made[0].output, out() / "cloud.laz");
  EXPECT_EQ(made[0].points, 400u);
  EXPECT_EQ(made[0].outside, 0u);
  const auto again =
      triangulate({made[0].output.string()}, TriangulationOptions().dimension(2).attributes({"HeightAboveGround"}));
  const auto attributes = again.tile(0).attributes();
  EXPECT_TRUE(std::any_of(attributes.begin(), attributes.end(),
                          [](const auto& attribute) { return attribute.name == "HeightAboveGround"; }));
}

TEST_F(Heights, WhatMakesNoSenseIsRefusedInTheWordsOfTheLibrary) {
  const auto says = [&](const HeightsRequest& request) {
    return std::string(failure_of([&] { write_heights({cloud()}, out(), request); }).what());
  };
  EXPECT_EQ(says(HeightsRequest().format("copc")),
            "format: 'copc' is not a format of the copies; the formats are las and laz");
  EXPECT_EQ(says(HeightsRequest().outside(std::numeric_limits<double>::infinity())), "outside: must be finite");
  EXPECT_EQ(says(HeightsRequest().ground(ground()).ground_class(2)),
            "ground_class: says of which points the ground is made, but ground gives the ground");
  EXPECT_EQ(failure_of([&] { write_heights({}, out()); }).cause(), Cause::usage);
  write_heights({cloud()}, out(), HeightsRequest().ground(ground()));
  EXPECT_EQ(says(HeightsRequest().ground(ground())),
            (out() / "cloud.las").string() + ": exists already; overwrite(true) replaces it");
}

}  // namespace
}  // namespace tessera
