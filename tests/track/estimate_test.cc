#include "src/surface/track/estimate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "src/input/cloud/cloud.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

// A plane that flies at 60 m/s, 1000 above the ground; `wrong` of the pulses point anywhere.
std::vector<Pulse> flown(std::uint32_t line, double seconds, double wrong, unsigned seed) {
  std::mt19937_64 random(seed);
  const auto between = [&](double lo, double hi) {
    return lo + (hi - lo) * static_cast<double>(random() >> 11u) * 0x1p-53;
  };
  std::vector<Pulse> pulses;
  for (double time = 1000; time < 1000 + seconds; time += 0.002) {
    const Point at{60 * (time - 1000), 5, 1000};
    const Point ground{at.x + between(-30, 30), between(-400, 400), 0};
    const double part = between(5, 25) / 1000;
    const auto noisy = [&](Point p) {
      return Point{p.x + between(-0.02, 0.02), p.y + between(-0.02, 0.02), p.z + between(-0.02, 0.02)};
    };
    const bool is_wrong = between(0, 1) < wrong;
    const Point first{ground.x + (at.x - ground.x) * part + (is_wrong ? between(-20, 20) : 0),
                      ground.y + (at.y - ground.y) * part + (is_wrong ? between(-20, 20) : 0), 1000 * part};
    pulses.push_back({line, time, noisy(first), noisy(ground)});
  }
  return pulses;
}

double off(const EstimatedTrack& found, std::uint32_t line, double time) {
  const auto at = found.track.at(line, time);
  return at ? std::hypot(at->x - 60 * (time - 1000), at->y - 5, at->z - 1000) : 1e9;
}

TEST(EstimateTrack, FindsThePlane) {
  const auto found = estimate_track(flown(4, 6, 0, 1), {});
  ASSERT_EQ(found.lines.size(), 1u);
  EXPECT_EQ(found.lines[0].refused, "");
  EXPECT_EQ(found.lines[0].kept, 12u);
  EXPECT_NEAR(found.lines[0].height, 985, 15);
  EXPECT_LT(found.lines[0].median_degrees, 0.6);  // the plane flies on in half a second
  for (const double time : {1000.5, 1002.3, 1005.7}) EXPECT_LT(off(found, 4, time), 40);
}

TEST(EstimateTrack, FindsThePlaneAmongAThirdOfWrongPulses) {
  const auto found = estimate_track(flown(4, 6, 0.33, 2), {});
  EXPECT_EQ(found.lines[0].refused, "");
  for (const double time : {1000.5, 1002.3, 1005.7}) EXPECT_LT(off(found, 4, time), 60);
}

TEST(EstimateTrack, RefusesALineWhosePulsesDoNotComeTogether) {
  auto pulses = flown(4, 4, 0, 3);
  const auto wrong = flown(9, 4, 1, 4);
  pulses.insert(pulses.end(), wrong.begin(), wrong.end());
  const auto found = estimate_track(pulses, {});
  ASSERT_EQ(found.lines.size(), 2u);
  EXPECT_EQ(found.lines[0].refused, "");
  EXPECT_NE(found.lines[1].refused, "");
  EXPECT_EQ(found.track.lines().count(9), 0u);
  EXPECT_EQ(found.track.at(9, 1002), std::nullopt);
}

TEST(EstimateTrack, RefusesPulsesThatMeetBelowTheGroundOrNowhere) {
  auto below = flown(1, 3, 0, 5);
  for (Pulse& p : below) std::swap(p.first, p.last);  // they point down
  EXPECT_NE(estimate_track(below, {}).lines[0].refused, "");
  auto mirrored = flown(1, 3, 0, 6);
  for (Pulse& p : mirrored) {  // the lines meet 1000 below
    p.first.x = 2 * p.last.x - p.first.x;
    p.first.y = 2 * p.last.y - p.first.y;
  }
  EXPECT_NE(estimate_track(mirrored, {}).lines[0].refused, "");
  auto parallel = flown(1, 3, 0, 7);
  for (Pulse& p : parallel) p.first = {p.last.x + 1, p.last.y, p.last.z + 10};
  EXPECT_NE(estimate_track(parallel, {}).lines[0].refused, "");
  EXPECT_NE(estimate_track(std::vector<Pulse>{{1, 0.5, {0, 0, 9}, {0, 0, 0}}}, {}).lines[0].refused, "");
  EXPECT_TRUE(estimate_track({}, {}).lines.empty());
}

// Rows of return_number, number_of_returns (u8), gps_time (f64), point_source_id (u16).
const std::vector<Attribute> schema{{"return_number", AttributeType::u8},
                                    {"number_of_returns", AttributeType::u8},
                                    {"gps_time", AttributeType::f64},
                                    {"point_source_id", AttributeType::u16}};
struct Returned {
  Point at;
  std::uint8_t number, count;
  double time;
  std::uint16_t line;
};
void add(Pulses& pulses, const Returned& r) {
  std::vector<std::byte> row(12);
  std::memcpy(&row[0], &r.number, 1);
  std::memcpy(&row[1], &r.count, 1);
  std::memcpy(&row[2], &r.time, 8);
  std::memcpy(&row[10], &r.line, 2);
  pulses.add(r.at, row.data());
}

TEST(Pulses, AreFoundInAnyOrderAndOnlyWhereNothingIsAmbiguous) {
  std::vector<Returned> returns{{{0, 0, 9}, 1, 3, 1.5, 2}, {{0, 0, 5}, 2, 3, 1.5, 2}, {{0, 0, 1}, 3, 3, 1.5, 2},
                                {{0, 0, 1}, 3, 3, 1.5, 2}, {{1, 0, 9}, 1, 2, 1.5, 3}, {{1, 0, 1}, 2, 2, 1.5, 3},
                                {{2, 0, 9}, 1, 2, 1.7, 3}, {{2, 0, 1}, 1, 1, 1.7, 3}, {{3, 0, 9}, 1, 2, 1.9, 3},
                                {{3, 1, 9}, 1, 2, 1.9, 3}, {{3, 0, 1}, 2, 2, 1.9, 3}};
  std::mt19937_64 random(1);
  for (int round = 0; round < 20; ++round) {
    std::shuffle(returns.begin(), returns.end(), random);
    Pulses one(schema), two(schema);
    ASSERT_EQ(one.missing(), "");
    for (std::size_t i = 0; i < returns.size(); ++i) add(i % 2 == 0 ? one : two, returns[i]);
    one.add(two);
    const auto pulses = one.take();
    ASSERT_EQ(pulses.size(), 2u);
    EXPECT_EQ(pulses[0].line, 2u);
    EXPECT_EQ(pulses[0].first, (Point{0, 0, 9}));
    EXPECT_EQ(pulses[0].last, (Point{0, 0, 1}));
    EXPECT_EQ(pulses[1].first, (Point{1, 0, 9}));
  }
  EXPECT_EQ(Pulses({{"gps_time", AttributeType::f64}}).missing(), "return_number");
}

TEST(Pulses, ThatAreTooManyAreTheSameFewInAnyOrder) {
  std::vector<Returned> returns;
  for (int i = 0; i < 5000; ++i) {
    const double time = i * 0.01;
    returns.push_back({{time, 0, 9}, 1, 2, time, 1});
    returns.push_back({{time, 0, 1}, 2, 2, time, 1});
  }
  std::vector<double> wanted;
  std::mt19937_64 random(1);
  for (int round = 0; round < 5; ++round) {
    Pulses parts[2] = {Pulses(schema, 1000), Pulses(schema, 1000)};
    for (std::size_t i = 0; i < returns.size(); ++i) add(parts[i % 7 == 0 ? 1 : 0], returns[i]);
    parts[0].add(parts[1]);
    std::vector<double> times;
    for (const Pulse& pulse : parts[0].take()) times.push_back(pulse.time);
    EXPECT_GT(times.size(), 200u);
    EXPECT_LE(times.size(), 500u);
    if (round == 0) wanted = times;
    EXPECT_EQ(times, wanted);
    std::shuffle(returns.begin(), returns.end(), random);
  }
}

const fs::path bundled = fs::path(TESSERA_TEST_DATA) / "clouds", more = TESSERA_MORE_CLOUDS;

EstimatedTrack of_file(const fs::path& file) {
  CloudOptions options;
  options.attributes = {"all"};
  const Cloud cloud = Cloud::open({file.string()}, options).value();
  Pulses pulses(cloud.schema());
  EXPECT_EQ(pulses.missing(), "");
  const std::size_t width = row_bytes(cloud.schema());
  EXPECT_TRUE(cloud.for_each_batch([&](CloudBatch& batch) -> Status {
    for (std::size_t i = 0; i < batch.points.size(); ++i) pulses.add(batch.points[i].at, batch.rows.data() + i * width);
    return success();
  }));
  return estimate_track(pulses.take(), {});
}

TEST(EstimateTrack, OfTheBundledBlockHasBothLines) {
  const auto found = of_file(bundled / "ign_77055_627755.laz");
  ASSERT_EQ(found.lines.size(), 2u);
  for (const TrackLine& line : found.lines) {
    EXPECT_EQ(line.refused, "");
    EXPECT_NEAR(line.height, 1420, 60);
    EXPECT_LT(line.median_degrees, 0.3);
  }
}

// Above the points, in units of the coordinates: of each line whose track is found.
struct Flown {
  double height = 0, within = 0;
  std::size_t lines = 0;
  bool whole = true;  // all half seconds agree; else some must be found out: they would be below the ground
};
Flown flown_of(const std::string& name) {
  if (name == "autzen_trim.laz") return {2700, 30, 1, false};
  if (name == "lidr_topography.laz") return {2288, 30, 1};
  if (name == "bcts_1.laz") return {705, 40, 3};
  return {1527, 30, 1, false};  // lidr_megaplot.laz
}

class TrackOfRealCloud : public testing::TestWithParam<fs::path> {};

TEST_P(TrackOfRealCloud, IsWhereItWasFlown) {
  const Flown wanted = flown_of(GetParam().filename());
  const auto found = of_file(GetParam());
  ASSERT_EQ(found.lines.size(), wanted.lines);
  for (const TrackLine& line : found.lines) {
    EXPECT_EQ(line.refused, "");
    EXPECT_NEAR(line.height, wanted.height, wanted.within);
    EXPECT_LT(line.median_degrees, 0.7);
    EXPECT_EQ(line.kept == line.windows, wanted.whole);
    for (const Track::TrackPoint& point : found.track.lines().at(line.line))
      EXPECT_NEAR(point.at.z, found.track.lines().at(line.line).front().at.z, wanted.height / 5);
  }
}
// A bundled one, and more where there are more.
std::vector<fs::path> real_clouds() {
  std::vector<fs::path> files{bundled / "autzen_trim.laz"};
  if (!fs::is_directory(more)) return files;
  for (const char* name : {"lidr_topography.laz", "bcts_1.laz", "lidr_megaplot.laz"}) files.push_back(more / name);
  return files;
}
std::string name_of(const testing::TestParamInfo<fs::path>& file) { return file.param.stem(); }
INSTANTIATE_TEST_SUITE_P(Files, TrackOfRealCloud, testing::ValuesIn(real_clouds()), name_of);

}  // namespace
}  // namespace tessera
