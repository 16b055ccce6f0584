#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "src/input/cloud/cloud.h"
#include "src/surface/track/estimate.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr double degree = 0.017453292519943295;

struct Flight {
  double degrees_max = 15;  // to both sides
  double crab = 0;          // degrees between the way of the scanner's nose and its way over ground
  double rounded_to = 1;    // degrees; 0: not at all
  double wrong = 0;         // part of angles that are anything
  double relief = 60;       // of the ground
  bool mirrored = false;    // angles are positive to the other side
};

// A plane that flies at 60 m/s along x, 1000 above the ground's lowest.
std::vector<AngledPoint> flown(std::uint32_t line, double seconds, const Flight& flight, unsigned seed) {
  std::mt19937_64 random(seed);
  const auto between = [&](double lo, double hi) {
    return lo + (hi - lo) * static_cast<double>(random() >> 11u) * 0x1p-53;
  };
  std::vector<AngledPoint> points;
  for (double time = 1000; time < 1000 + seconds; time += 0.001) {
    const double sweep = std::fmod(time * 30, 2.0);  // thirty sweeps a second
    const double angle = flight.degrees_max * (2 * std::abs(sweep - 1) - 1);
    const double z = between(0, flight.relief), across = (1000 - z) * std::tan(angle * degree);
    const Point at{60 * (time - 1000) + across * std::sin(flight.crab * degree) + 5e5,
                   across * std::cos(flight.crab * degree) + 6e6, z};
    double told = between(0, 1) < flight.wrong ? between(-15, 15) : angle;
    if (flight.rounded_to > 0) told = std::round(told / flight.rounded_to) * flight.rounded_to;
    points.push_back({line, time, flight.mirrored ? -told : told, at});
  }
  return points;
}

double off(const EstimatedTrack& found, std::uint32_t line, double time) {
  const auto at = found.track.at(line, time);
  return at ? std::hypot(at->x - 60 * (time - 1000) - 5e5, at->y - 6e6, at->z - 1000) : 1e9;
}

void expect_found(const Flight& flight, double within, unsigned seed) {
  const auto found = estimate_track({}, flown(4, 6, flight, seed));
  ASSERT_EQ(found.lines.size(), 1u);
  EXPECT_EQ(found.lines[0].refused, "");
  EXPECT_EQ(found.lines[0].from, TrackLine::From::angles);
  EXPECT_EQ(found.lines[0].kept, 12u);
  EXPECT_LT(found.lines[0].median_degrees, 0.5);
  for (const double time : {1000.5, 1002.3, 1005.7}) EXPECT_LT(off(found, 4, time), within);
}

TEST(EstimateTrackByAngles, FindsThePlane) {
  expect_found({.rounded_to = 0}, 1, 1);
  expect_found({}, 10, 2);
  expect_found({.mirrored = true}, 10, 3);
  expect_found({.crab = 12}, 20, 4);
}

TEST(EstimateTrackByAngles, FindsThePlaneFromFewDegreesInWholeOnes) { expect_found({.degrees_max = 3}, 60, 5); }

TEST(EstimateTrackByAngles, FindsThePlaneAmongWrongAngles) { expect_found({.wrong = 0.2}, 60, 6); }

TEST(EstimateTrackByAngles, RefusesAnglesThatTellNothing) {
  const auto refused = [](const std::vector<AngledPoint>& points) {
    const auto found = estimate_track({}, points);
    return found.lines.size() == 1 && !found.lines[0].refused.empty() && found.track.empty();
  };
  EXPECT_TRUE(refused(flown(1, 3, {.degrees_max = 0.9}, 1)));
  EXPECT_TRUE(refused(flown(1, 3, {.wrong = 1}, 2)));
  auto points = flown(1, 3, {}, 3);
  for (AngledPoint& p : points) p.degrees = 0;
  EXPECT_TRUE(refused(points));
  for (AngledPoint& p : points) p.degrees = p.time > 1001.5 ? 10 : -10;
  EXPECT_TRUE(refused(points));
  points = flown(1, 3, {}, 4);
  for (AngledPoint& p : points) p.at = {5e5, 6e6, 1};
  EXPECT_TRUE(refused(points));
  points = flown(1, 3, {}, 5);
  for (AngledPoint& p : points) p.at.x = p.at.y = 1e300 * p.at.z;
  EXPECT_TRUE(refused(points));
  EXPECT_TRUE(refused({{1, 1000, 3, {0, 0, 0}}}));
}

TEST(EstimateTrackByAngles, IsForLinesWhosePulsesTellNothing) {
  auto points = flown(4, 3, {}, 1);
  const auto others = flown(9, 3, {}, 2);
  points.insert(points.end(), others.begin(), others.end());
  const std::vector<Pulse> one{{4, 1000.25, {0, 0, 9}, {0, 0, 0}}, {7, 1000.25, {0, 0, 9}, {0, 0, 0}}};
  const auto found = estimate_track(one, points);
  ASSERT_EQ(found.lines.size(), 3u);
  EXPECT_EQ(found.lines[0].line, 4u);
  EXPECT_EQ(found.lines[0].from, TrackLine::From::angles);
  EXPECT_EQ(found.lines[0].refused, "");
  EXPECT_EQ(found.lines[1].line, 7u);
  EXPECT_EQ(found.lines[1].refused, "too few pulses with several returns");
  EXPECT_EQ(found.lines[2].refused, "");
  EXPECT_EQ(found.track.lines().size(), 2u);
}

// Rows of scan_angle (f32), gps_time (f64), point_source_id (u16).
const std::vector<Attribute> schema{
    {"scan_angle", AttributeType::f32}, {"gps_time", AttributeType::f64}, {"point_source_id", AttributeType::u16}};
void add(ScanAngles& angles, const AngledPoint& p) {
  std::vector<std::byte> row(14);
  const auto degrees = static_cast<float>(p.degrees);
  const auto line = static_cast<std::uint16_t>(p.line);
  std::memcpy(&row[0], &degrees, 4);
  std::memcpy(&row[4], &p.time, 8);
  std::memcpy(&row[12], &line, 2);
  angles.add(p.at, row.data());
}

TEST(ScanAngles, ThatAreTooManyAreTheSameFewInAnyOrder) {
  auto points = flown(3, 4, {}, 1);

  std::vector<double> wanted;
  std::mt19937_64 random(1);
  for (int round = 0; round < 5; ++round) {
    ScanAngles one(schema, 1000), two(schema, 1000);
    for (std::size_t i = 0; i < points.size(); ++i) add(i % 7 == 0 ? one : two, points[i]);
    one.add(two);
    std::vector<double> times;
    for (const AngledPoint& point : one.take()) times.push_back(point.time);
    EXPECT_GT(times.size(), 400u);
    EXPECT_LE(times.size(), 1000u);
    if (round == 0) wanted = times;
    EXPECT_EQ(times, wanted);
    std::shuffle(points.begin(), points.end(), random);
  }
  EXPECT_EQ(ScanAngles({{"gps_time", AttributeType::f64}}).missing(), "scan_angle");
  ScanAngles wrong(schema);
  add(wrong, {1, std::nan(""), 3, {0, 0, 0}});
  add(wrong, {1, 2, 89.9, {0, 0, 0}});
  add(wrong, {1, 2, std::nan(""), {0, 0, 0}});
  EXPECT_TRUE(wrong.take().empty());
}

// Both ways to find a scanner, on clouds that allow both.
class AnglesOfRealCloud : public testing::TestWithParam<fs::path> {};

TEST_P(AnglesOfRealCloud, SayWhatPulsesSay) {
  CloudOptions options;
  options.attributes = {"all"};
  const Cloud cloud = Cloud::open({GetParam().string()}, options).value();
  Pulses pulses(cloud.schema());
  ScanAngles angles(cloud.schema());
  ASSERT_EQ(angles.missing(), "");
  const std::size_t width = row_bytes(cloud.schema());
  ASSERT_TRUE(cloud.for_each_batch([&](CloudBatch& batch) -> Status {
    for (std::size_t i = 0; i < batch.points.size(); ++i) {
      pulses.add(batch.points[i].at, batch.rows.data() + i * width);
      angles.add(batch.points[i].at, batch.rows.data() + i * width);
    }
    return success();
  }));
  const auto points = angles.take();
  const auto by_pulses = estimate_track(pulses.take(), {}), by_angles = estimate_track({}, points);
  ASSERT_EQ(by_angles.lines.size(), by_pulses.lines.size());
  for (std::size_t i = 0; i < by_angles.lines.size(); ++i) {
    EXPECT_EQ(by_angles.lines[i].refused, "");
    EXPECT_NEAR(by_angles.lines[i].height, by_pulses.lines[i].height, 0.05 * by_pulses.lines[i].height);
  }
  std::vector<double> apart;  // degrees between the ways to both places
  for (const AngledPoint& p : points) {
    const auto one = by_pulses.track.at(p.line, p.time), two = by_angles.track.at(p.line, p.time);
    if (!one || !two) continue;
    const double a[3] = {one->x - p.at.x, one->y - p.at.y, one->z - p.at.z},
                 b[3] = {two->x - p.at.x, two->y - p.at.y, two->z - p.at.z};
    const double cosine =
        (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) / (std::hypot(a[0], a[1], a[2]) * std::hypot(b[0], b[1], b[2]));
    apart.push_back(std::acos(std::min(cosine, 1.0)) / degree);
  }
  EXPECT_GT(apart.size(), points.size() * 4 / 5);
  std::sort(apart.begin(), apart.end());
  const double median = apart[apart.size() / 2], most = apart[apart.size() * 99 / 100];
  RecordProperty("median_degrees", std::to_string(median));
  RecordProperty("degrees_of_99_percent", std::to_string(most));
  // Scan angles know nothing of the plane's pitch, and those of bcts_1 nothing of its roll.
  EXPECT_LT(median, 5);
  EXPECT_LT(most, 8);
}
std::vector<fs::path> real_clouds() {
  std::vector<fs::path> files{fs::path(TESSERA_TEST_DATA) / "clouds/autzen_trim.laz"};
  const fs::path more = TESSERA_MORE_CLOUDS;
  if (!fs::is_directory(more)) return files;
  for (const char* name : {"lidr_topography.laz", "bcts_1.laz"}) files.push_back(more / name);
  return files;
}
std::string name_of(const testing::TestParamInfo<fs::path>& file) { return file.param.stem(); }
INSTANTIATE_TEST_SUITE_P(Files, AnglesOfRealCloud, testing::ValuesIn(real_clouds()), name_of);

}  // namespace
}  // namespace tessera
