// How triangulate() fails, and that nothing is left when it does.
#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <stdexcept>
#include <thread>

#include "tests/api/api_testing.h"
#include "tests/api/temporary_home.h"

namespace tessera {
namespace {

using testing::cloud;
using testing::failure_of;

class TriangulateErrors : public ::testing::Test {
 protected:
  static TriangulationOptions small_job() {
    TriangulationOptions options;
    options.threads(2);
    options.memory_bytes(std::uint64_t{1} << 30);
    return options;
  }
  void expect(const Failure& failure, Cause cause, const std::string& sentence) const {
    EXPECT_EQ(failure.cause(), cause);
    EXPECT_EQ(failure.what(), sentence);
    EXPECT_EQ(home_.entries(), 0u) << "something is left";
  }
  void expect_array(const std::vector<double>& points, int dimension, Cause cause, const std::string& sentence) const {
    auto options = small_job();
    options.dimension(dimension);
    expect(failure_of([&] { triangulate(points, options); }), cause, sentence);
  }
  const testing::TemporaryHome home_;
};

TEST_F(TriangulateErrors, OfAnArrayNameItAndTheRow) {
  auto points = cloud("uniform", 3, 100);
  expect_array(points, 0, Cause::usage, "dimension: must be 2 or 3 for an array");
  points.pop_back();
  expect_array(points, 3, Cause::usage, "the array: its length, 299, is not a multiple of the dimension, 3");
  expect_array({}, 3, Cause::bad_input, "the array: there are no points");
  expect_array({0, 0, 1, 1, 2, 2}, 2, Cause::bad_input,
               "the array: all 3 points lie on one line; a 2D triangulation needs points off it");
  points.push_back(0);
  points[17 * 3 + 1] = std::numeric_limits<double>::quiet_NaN();
  expect_array(points, 3, Cause::bad_input,
               "the array, row 17: y is nan (skip_invalid(true) drops such points and counts them)");
  auto options = small_job();
  options.skip_invalid(true);
  EXPECT_EQ(triangulate(points, options).vertices(), 99u);
}

TEST_F(TriangulateErrors, OfOptionsAreUsage) {
  const auto points = cloud("uniform", 3, 100);
  auto options = small_job();
  options.threads(5000);
  expect(failure_of([&] { triangulate(points, options); }), Cause::usage, "threads: 5000 is more than the limit, 1024");
  options = small_job();
  options.attributes({"colour"});
  expect(failure_of([&] { triangulate(points, options); }), Cause::usage,
         "no input file has an attribute 'colour'; there are none");
  expect(failure_of([] { triangulate(std::vector<std::string>{}); }), Cause::usage, "no input file is given");
}

TEST_F(TriangulateErrors, OfTooLittleMemorySaysSo) {
  auto options = small_job();
  options.memory_bytes(1 << 20);
  const auto failure = failure_of([&] { triangulate(cloud("uniform", 3, 20'000), options); });
  EXPECT_EQ(failure.cause(), Cause::memory);
  EXPECT_NE(std::string(failure.what()).find("memory_bytes is too small for 2 threads"), std::string::npos);
  EXPECT_EQ(std::string(failure.what()).find("--"), std::string::npos) << "an option of the command";
}

TEST_F(TriangulateErrors, OfFilesNameThem) {
  const std::string missing = "/nowhere/at/all.las";
  expect(failure_of([&] { triangulate({missing}, small_job()); }), Cause::io,
         missing + ": cannot be opened: No such file or directory");
  auto options = small_job();
  options.folder("/nowhere/at/all");
  expect(failure_of([&] { triangulate(cloud("uniform", 3, 10), options); }), Cause::io,
         "/nowhere/at/all: the folder around it does not exist");
  EXPECT_EQ(failure_of([] { Triangulation::open("/nowhere"); }).cause(), Cause::io);
}

TEST_F(TriangulateErrors, OfDamagedResultsAreCorrupt) {
  auto options = small_job();
  options.folder(home_.path() / "out");
  const auto t = triangulate(cloud("uniform", 3, 100), options);
  EXPECT_EQ(failure_of([&] { t.tile(1); }).cause(), Cause::usage);
  std::ofstream(home_.path() / "out" / "tiles" / "000000.vtu") << "nonsense";
  EXPECT_EQ(failure_of([&] { t.tile(0); }).cause(), Cause::corrupt);
  std::ofstream(home_.path() / "out" / "manifest.json") << "nonsense";
  EXPECT_EQ(failure_of([&] { Triangulation::open(home_.path() / "out"); }).cause(), Cause::corrupt);
}

// Long enough that the first call comes long before the end.
std::vector<double> many_points() { return cloud("uniform", 3, 200'000); }

TEST_F(TriangulateErrors, AnExceptionOfTheCallbackEndsTheJobAndComesOut) {
  struct Enough : std::runtime_error {
    using std::runtime_error::runtime_error;
  };
  for (const bool named : {false, true}) {
    auto options = small_job();
    if (named) options.folder(home_.path() / "out");
    std::string phase;
    options.progress([&](const JobProgress& now) {
      phase = now.phase;
      throw Enough("as it is");
    });
    EXPECT_THROW(
        {
          try {
            triangulate(many_points(), options);
          } catch (const Enough& thrown) {
            EXPECT_STREQ(thrown.what(), "as it is");
            throw;
          }
        },
        Enough);
    EXPECT_NE(phase, "done");
    EXPECT_EQ(home_.entries(), 0u);
  }
}

TEST_F(TriangulateErrors, AStopThatIsRequestedEndsTheJob) {
  std::stop_source stop;
  auto options = small_job();
  options.stop(stop.get_token());
  options.folder(home_.path() / "out");
  options.progress([&](const JobProgress&) { stop.request_stop(); });
  expect(failure_of([&] { triangulate(many_points(), options); }), Cause::interrupted, "stopped, as was requested");
  options.progress({});
  expect(failure_of([&] { triangulate(many_points(), options); }), Cause::interrupted, "stopped, as was requested");
}

TEST_F(TriangulateErrors, AJobThatFailsLeavesTheFolderAsItWas) {
  const auto points = cloud("uniform", 3, 200);
  auto options = small_job();
  options.folder(home_.path() / "out");
  triangulate(points, options);
  options.overwrite(true);
  EXPECT_EQ(failure_of([&] { triangulate(std::vector<double>{0, 0, 0}, options); }).cause(), Cause::bad_input);
  EXPECT_EQ(testing::cells_of(Triangulation::open(home_.path() / "out")), testing::expected_cells(points, 3));
}

}  // namespace
}  // namespace tessera
