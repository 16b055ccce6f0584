#include "src/surface/track/track.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace tessera {
namespace {

class TrackFile : public testing::Test {
 protected:
  TrackFile() : path_(std::filesystem::temp_directory_path() / ("track-" + std::to_string(::getpid()) + ".csv")) {}
  ~TrackFile() override { std::filesystem::remove(path_); }
  Result<Track> read(const std::string& text) {
    std::ofstream(path_) << text;
    return Track::read(path_);
  }
  std::string refused(const std::string& text) {
    const auto track = read(text);
    return track ? std::string("not refused") : track.error().where;
  }
  std::filesystem::path path_;
};

TEST_F(TrackFile, IsReadAsItIsWritten) {
  Track track;
  track.add(7, {{0.1, {1.0 / 3, -2e-7, 1e6}}, {0.6, {2, 3, 4}}});
  track.add(3, {{5e8 + 0.25, {770500.123456789, 6277500, 1400}}});
  const Track back = read(track.to_csv()).value();
  EXPECT_EQ(back.to_csv(), track.to_csv());
  EXPECT_EQ(back.at(7, 0.1), track.at(7, 0.1));
  EXPECT_TRUE(back.tells_lines());
}

TEST_F(TrackFile, MayHaveItsColumnsInAnyOrderAndOthersBesides) {
  const Track track = read("z, roll,time,y ,x\r\n3,0.1,10,2,1\r\n\r\n6,0.1,12,4,2\r\n").value();
  EXPECT_FALSE(track.tells_lines());
  EXPECT_EQ(track.at(99, 11), (Point{1.5, 3, 4.5}));
}

TEST_F(TrackFile, IsRefusedWithItsLine) {
  EXPECT_NE(refused("").find(": is empty"), std::string::npos);
  EXPECT_NE(refused("time,x,y\n1,2,3\n").find("line 1: the header names no column 'z'"), std::string::npos);
  EXPECT_NE(refused("time,x,y,z\n").find("has no positions"), std::string::npos);
  EXPECT_NE(refused("time,x,y,z\n1,2,3,4\n2,2,3\n").find("line 3: has no column 'z'"), std::string::npos);
  EXPECT_NE(refused("time,x,y,z\n1,2,3,north\n").find("line 2: z is not a finite number"), std::string::npos);
  EXPECT_NE(refused("time,x,y,z\n1,2,inf,4\n").find("line 2: y is not a finite number"), std::string::npos);
  EXPECT_NE(refused("time,x,y,z\n2,2,3,4\n2,2,3,4\n").find("line 3: its time is not after"), std::string::npos);
  EXPECT_NE(refused("time,x,y,z,line\n2,2,3,4,1.5\n").find("line 2: line is not a whole number"), std::string::npos);
  EXPECT_NE(refused("time,x,y,z,line\n2,2,3,4,-1\n").find("line 2: line is not a whole number"), std::string::npos);
}

TEST_F(TrackFile, ThatIsNotThereIsToldOf) {
  const auto track = Track::read(path_);
  ASSERT_FALSE(track);
  EXPECT_NE(track.error().where.find(path_.string()), std::string::npos);
}

TEST(Track, KnowsPlacesBetweenAndALittleBeyond) {
  Track track;
  track.add(1, {{10, {0, 0, 100}}, {12, {20, 0, 100}}, {40, {0, 0, 50}}});
  EXPECT_EQ(track.at(1, 11), (Point{10, 0, 100}));
  EXPECT_EQ(track.at(1, 9.5), (Point{-5, 0, 100}));
  EXPECT_EQ(track.at(1, 8.9), std::nullopt);
  EXPECT_EQ(track.at(1, 12.5), (Point{25, 0, 100}));
  EXPECT_EQ(track.at(1, 20), std::nullopt);  // in a gap
  EXPECT_EQ(track.at(1, 39.5), (Point{0, 0, 50}));
  EXPECT_EQ(track.at(1, 41.5), std::nullopt);
  EXPECT_EQ(track.at(2, 11), std::nullopt);
}

}  // namespace
}  // namespace tessera
