// Several files in parallel: nothing but the time may depend on the number of threads.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "src/input/cloud/cloud.h"
#include "src/input/cloud/cloud_sample.h"
#include "tests/input/las_file.h"

namespace tessera::testing_io {
namespace {

struct Seen {
  std::vector<std::size_t> batches;
  std::vector<LocalPoint> points;
  Bytes rows;
  CloudCounts counts;
  std::vector<Point> sample;
  std::string error;
};

Seen see(const std::string& folder, CloudOptions options, std::uint32_t threads) {
  Seen seen;
  options.threads = threads;
  const auto cloud = Cloud::open({folder}, options);
  if (cloud.has_error()) {
    seen.error = sentence(cloud);
    return seen;
  }
  const auto self = std::this_thread::get_id();
  const auto counts = cloud.value().for_each_batch([&](CloudBatch& batch) -> Status {
    EXPECT_EQ(std::this_thread::get_id(), self);
    seen.batches.push_back(batch.points.size());
    seen.points.insert(seen.points.end(), batch.points.begin(), batch.points.end());
    seen.rows.insert(seen.rows.end(), batch.rows.begin(), batch.rows.end());
    return success();
  });
  if (counts.has_error()) {
    seen.error = sentence(counts);
    return seen;
  }
  seen.counts = counts.value();
  const auto sample = sample_cloud(cloud.value(), 5000);
  if (sample) seen.sample = sample.value();
  return seen;
}

class CloudThreads : public testing::Test {
 protected:
  std::string at(const std::string& name) const { return (folder_.path() / name).string(); }

  void text(const std::string& name, int points, const std::string& more = "") {
    std::string lines = "x,y,z,intensity\n";
    for (int i = 0; i < points; ++i)
      lines += std::to_string(random_() % 1000) + "," + std::to_string(random_() % 1000) + "," +
               std::to_string(random_() % 10) + "," + std::to_string(random_() % 99) + "\n";
    folder_.write(name, lines + more);
  }
  void las(const std::string& name, int points) {
    LasFile file;
    file.scale = {1, 1, 1};
    for (int i = 0; i < points; ++i)
      file.points.push_back({static_cast<int>(random_() % 1000), static_cast<int>(random_() % 1000), i % 10});
    folder_.write(name, file.bytes());
  }
  void copy(const std::string& name, const std::string& to) const {
    std::filesystem::copy_file(TESSERA_TEST_DATA "/../fuzz/corpus/" + name, folder_.path() / to);
  }

  // Files of several formats, in names that mix them: small ones, some that are read while they are used, empty ones.
  void many_files() {
    for (int i = 0; i < 40; ++i) {
      const std::string name = std::to_string(100 + i);
      if (i % 3 == 0) text(name + ".csv", 5 + i * 17);
      if (i % 3 == 1) las(name + ".las", i * 31);
      if (i % 10 == 2) copy("laz/lone_star.laz", name + ".laz");
      if (i % 10 == 7) copy("laz/small.copc.laz", name + ".copc.laz");
      if (i % 10 == 5) copy("ply/list_little.ply", name + ".ply");
      if (i % 10 == 8) copy("npy/le_f8_3.npy", name + ".npy");
    }
    las("110_large.las", 200'000);
    text("120_large.csv", 120'000);
    las("130_large.las", 70'000);
  }

  TempFolder folder_;
  std::mt19937 random_{1};
};

TEST_F(CloudThreads, ChangeNeitherPointsNorIdsNorRowsNorBatchesNorSample) {
  many_files();
  text("119.csv", 100, "nan,1,2,3\n4,5,inf,7\n1,2,3,\n");
  Box crop;
  crop.lo.x = 100;
  crop.hi.y = 900;
  const std::vector<CloudOptions> all_options{{.skip_invalid = true},
                                              {.dimension = 2, .skip_invalid = true, .attributes = {"all"}},
                                              {.skip_invalid = true, .crop = crop, .attributes = {"intensity"}}};
  for (const auto& options : all_options) {
    const auto expected = see(folder_.path().string(), options, 1);
    ASSERT_EQ(expected.error, "");
    EXPECT_GT(expected.points.size(), 300'000u);
    EXPECT_GT(expected.counts.invalid, 0u);
    for (const std::uint32_t threads : {2u, 3u, 8u, 2u}) {
      const auto got = see(folder_.path().string(), options, threads);
      ASSERT_EQ(got.error, "");
      EXPECT_EQ(got.batches, expected.batches);
      EXPECT_EQ(got.points, expected.points);
      EXPECT_EQ(got.rows, expected.rows);
      EXPECT_EQ(got.counts.read, expected.counts.read);
      EXPECT_EQ(got.counts.invalid, expected.counts.invalid);
      EXPECT_EQ(got.counts.filtered, expected.counts.filtered);
      EXPECT_EQ(got.sample, expected.sample);
    }
  }
}

TEST_F(CloudThreads, GiveTheIdsThatTheOrderOfTheInputSays) {
  many_files();
  const auto seen = see(folder_.path().string(), {}, 4);
  for (std::size_t i = 0; i < seen.points.size(); ++i) ASSERT_EQ(seen.points[i].id.value, i);
}

TEST_F(CloudThreads, ReportTheFirstErrorInInputOrder) {
  many_files();
  text("125.csv", 10, "1,2,nan,4\n");       // in a file that is read ahead
  text("129.csv", 10, "1,2,wrong\n");       // another behind it
  text("135.csv", 150'000, "1,2,wrong\n");  // and one that is read while it is used
  for (const std::uint32_t threads : {1u, 2u, 3u, 8u})
    for (int trial = 0; trial < 5; ++trial)
      EXPECT_EQ(see(folder_.path().string(), {}, threads).error,
                at("125.csv") + ", line 12: z is nan (skip-invalid=true drops such points and counts them)");
  std::filesystem::remove(at("125.csv"));
  std::filesystem::remove(at("129.csv"));
  for (const std::uint32_t threads : {1u, 2u, 8u})
    EXPECT_EQ(see(folder_.path().string(), {}, threads).error,
              at("135.csv") + ", line 150002: z is 'wrong', not a number");
  folder_.write("121.las", std::string("LASF and no more"));
  folder_.write("122.las", std::string("not even that"));
  const auto first = see(folder_.path().string(), {}, 1).error;
  EXPECT_EQ(first.find(at("121.las")), 0u) << first;
  for (const std::uint32_t threads : {2u, 8u}) EXPECT_EQ(see(folder_.path().string(), {}, threads).error, first);
}

TEST_F(CloudThreads, EndWhenTheVisitorStops) {
  many_files();
  for (const std::uint32_t threads : {1u, 2u, 8u}) {
    const auto cloud = Cloud::open({folder_.path().string()}, {.threads = threads});
    for (const int after : {0, 3, 12, 20}) {
      int batches = 0;
      const auto stopped = cloud.value().for_each_batch([&](CloudBatch&) -> Status {
        if (batches++ < after) return success();
        return error(Errc::interrupted, "enough");
      });
      EXPECT_EQ(sentence(stopped), "enough");
      EXPECT_EQ(batches, after + 1);
    }
  }
}

TEST_F(CloudThreads, ReadTenThousandFilesWithFewDescriptorsAndLittleMemory) {
  constexpr int files = 10'000;
  for (int i = 0; i < files; ++i) {
    const auto name = folder_.path() / (std::to_string(files + i) + ".xyz");
    std::ofstream(name) << i << " 0 0\n" << i << " 1 1\n";
  }
  struct rlimit old {};
  ::getrlimit(RLIMIT_NOFILE, &old);
  const struct rlimit few { 64, old.rlim_max };
  ::setrlimit(RLIMIT_NOFILE, &few);
  struct rusage before {
  }, after{};
  ::getrusage(RUSAGE_SELF, &before);
  for (const std::uint32_t threads : {1u, 8u}) {
    const auto seen = see(folder_.path().string(), {}, threads);
    EXPECT_EQ(seen.error, "");
    ASSERT_EQ(seen.points.size(), 2u * files);
    for (std::size_t i = 0; i < seen.points.size(); ++i)
      ASSERT_TRUE(seen.points[i].id.value == i && seen.points[i].at.x == static_cast<double>(i / 2));
  }
  ::getrusage(RUSAGE_SELF, &after);
  ::setrlimit(RLIMIT_NOFILE, &old);
#ifndef __SANITIZE_ADDRESS__  // which keeps what was freed for a while
  EXPECT_LT(after.ru_maxrss - before.ru_maxrss, 64 << 10) << "KiB";
#endif
}

TEST_F(CloudThreads, SettleTheDimensionByAllFiles) {
  folder_.write("a.xyz", "1 2\n");
  EXPECT_EQ(Cloud::open({at("a.xyz")}, {.dimension = 0}).value().options().dimension, 2);
  folder_.write("b.xyz", "1 2 3\n");
  EXPECT_EQ(Cloud::open({at("b.xyz")}, {.dimension = 0}).value().options().dimension, 3);
  EXPECT_EQ(sentence(Cloud::open({at("a.xyz"), at("b.xyz")}, {.dimension = 0})),
            at("a.xyz") + ": has only x and y, but a 3D triangulation needs z, too (see dim)");
}

}  // namespace
}  // namespace tessera::testing_io
