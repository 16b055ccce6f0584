// The fuzz corpus and all that fuzzing has found, through the readers in every build, also with sanitizers.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/fuzz/read_stranger.h"
#include "tests/fuzz/read_stranger_ept.h"

namespace tessera {
namespace {

std::vector<std::filesystem::path> files_below(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  if (!std::filesystem::exists(folder)) return files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

TEST(FuzzReplay, EveryKnownInputIsReadOrRefusedWithASentence) {
  auto files = files_below(TESSERA_FUZZ_CORPUS);
  ASSERT_GT(files.size(), 10u);
  for (auto& found : files_below(TESSERA_TEST_DATA "/fuzz")) files.push_back(found);
  for (const auto& file : files) {
    SCOPED_TRACE(file);
    std::ifstream in(file, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    for (const char* name :
         {"stranger.las", "stranger.ply", "stranger.off", "stranger.obj", "stranger.stl", "stranger.e57",
          "stranger.pcd", "stranger.ptx", "stranger.pts", "stranger.npy", "stranger.xyz", "stranger.xyz.gz"})
      read_stranger(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size(), name);
    read_stranger(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size(), "stranger.laz", stranger_hints());
    read_stranger(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size(), "stranger.fits", table_hints());
    read_stranger_ept(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  }
}

// Otherwise the corpus would say nothing of tiles.
TEST(FuzzReplay, CloudsInEptOfTheCorpusAreRead) {
  for (const auto& file : files_below(TESSERA_FUZZ_CORPUS "/ept")) {
    std::ifstream in(file, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    const auto source = std::make_shared<const StrangerEpt>("stranger/ept.json", std::as_bytes(std::span(bytes)));
    const auto reader = open_reader(share(source));
    ASSERT_TRUE(reader) << file << ": " << reader.error().where;
    PointBatch batch;
    std::uint64_t count = 0;
    do {
      ASSERT_TRUE(reader.value()->next(batch)) << file;
      count += batch.points.size();
    } while (!batch.points.empty());
    EXPECT_EQ(count, reader.value()->info().points) << file;
    EXPECT_GT(count, 0u) << file;
  }
}

}  // namespace
}  // namespace tessera
