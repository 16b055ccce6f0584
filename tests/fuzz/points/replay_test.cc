// The fuzz corpus of files of points and all that fuzzing has found, in every build, also with sanitizers.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "tests/fuzz/points/read_points.h"

namespace tessera {
namespace {

std::size_t replay(const std::filesystem::path& folder, std::size_t& tiles) {
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    SCOPED_TRACE(entry.path());
    std::ifstream in(entry.path(), std::ios::binary);
    std::string bytes{std::istreambuf_iterator<char>(in), {}};
    read_stranger_points(std::as_bytes(std::span(bytes)));
    set_sums(std::as_writable_bytes(std::span(bytes)));
    tiles += parse_points_file(std::as_bytes(std::span(bytes)), "seed", TileId{42}) ? 1 : 0;
    ++files;
  }
  return files;
}

TEST(PointsFuzzReplay, EveryKnownInputIsReadOrRefusedWithASentence) {
  std::size_t tiles = 0;
  EXPECT_GE(replay(TESSERA_FUZZ_CORPUS "/points", tiles), 5u);
  EXPECT_GE(tiles, 4u) << "seeds that are no files any more lead a fuzzer nowhere";
  replay(TESSERA_TEST_DATA "/fuzz", tiles);
}

}  // namespace
}  // namespace tessera
