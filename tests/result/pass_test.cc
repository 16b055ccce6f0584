#include "src/result/pass.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstring>
#include <filesystem>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "src/base/files/temporary.h"
#include "tests/store/sample_result.h"

namespace tessera::test {
namespace {

template <class Number>
std::vector<std::byte> bytes_of(const std::vector<Number>& numbers) {
  const auto bytes = std::as_bytes(std::span(numbers));
  return {bytes.begin(), bytes.end()};
}

struct Case {
  int dimension;
  std::uint32_t tiles;
  bool random;
  unsigned threads;
};

class Passes : public testing::TestWithParam<Case> {
 protected:
  Passes() {
    const auto points = sample_points(Shape::uniform, GetParam().dimension, 500);
    meshes_ = GetParam().random
                  ? sample_tiles(points, GetParam().dimension, GetParam().tiles,
                                 [&](std::size_t i) { return static_cast<std::uint32_t>(i * 7919 % GetParam().tiles); })
                  : sample_tiles(points, GetParam().dimension, GetParam().tiles);
    store_sample(out_, meshes_);
  }

  // Of own vertices: some function of id that only the owner can know; 0 for others. Of cells: how many vertices.
  Result<PassValues> compute(std::size_t index, const StoredTile& tile) const {
    std::vector<std::uint64_t> of_vertices(tile.mesh.ids.size(), 0);
    for (std::size_t v = 0; v < of_vertices.size(); ++v)
      if (tile.mesh.point_ghost[v] == 0) of_vertices[v] = tile.mesh.ids[v].value * 1000 + index;
    const std::vector<std::uint8_t> of_cells(tile.mesh.cell_ghost.size(), 5);
    return PassValues{bytes_of(of_vertices), bytes_of(of_cells)};
  }

  std::vector<TileMesh> meshes_;
  const TemporaryFolder folder_;
  const std::filesystem::path out_ = folder_.path() / "out";
};

INSTANTIATE_TEST_SUITE_P(Cases, Passes,
                         testing::Values(Case{2, 1, false, 1}, Case{2, 5, false, 2}, Case{3, 4, false, 3},
                                         Case{3, 6, true, 4}, Case{2, 7, true, 1}),
                         [](const auto& info) { return "c" + std::to_string(info.index); });

TEST_P(Passes, ForeignVerticesHaveTheValuesOfTheirOwners) {
  const auto source = TileSource::open(out_).value();
  std::map<PointId, std::uint64_t> expected;
  for (std::size_t i = 0; i < source.tiles(); ++i) {
    const auto mesh = source.read(i, {}).value().mesh;
    for (std::size_t v = 0; v < mesh.ids.size(); ++v)
      if (mesh.point_ghost[v] == 0) expected[mesh.ids[v]] = mesh.ids[v].value * 1000 + i;
  }
  auto scratch = tessera::TemporaryFolder::make().value();
  Pass pass(source, {{false, {"v", AttributeType::u64}}, {true, {"c", AttributeType::u8}}}, scratch.path(),
            {.threads = GetParam().threads, .memory_bytes = std::uint64_t{1} << 30});
  std::mutex mutex;
  std::set<std::size_t> seen;
  const auto done = pass.run([&](std::size_t i, const StoredTile& tile) { return compute(i, tile); },
                             [&](std::size_t i, const PassValues& values) -> Status {
                               const auto mesh = source.read(i, {}).value().mesh;
                               const std::lock_guard lock(mutex);
                               EXPECT_TRUE(seen.insert(i).second);
                               EXPECT_EQ(values[1], std::vector(mesh.cell_ghost.size(), std::byte{5}));
                               for (std::size_t v = 0; v < mesh.ids.size(); ++v) {
                                 std::uint64_t value = 0;
                                 std::memcpy(&value, &values[0][8 * v], sizeof value);
                                 EXPECT_EQ(value, expected.at(mesh.ids[v]));
                               }
                               return success();
                             });
  ASSERT_TRUE(done) << done.error().where;
  EXPECT_EQ(seen.size(), source.tiles());
  std::uint64_t put_down = 0;
  for (const auto& file : std::filesystem::recursive_directory_iterator(scratch.path()))
    put_down += file.is_regular_file() ? file.file_size() : 0;
  EXPECT_EQ(put_down, pass.scratch_bytes());
}

TEST_P(Passes, TheFirstErrorEndsIt) {
  const auto source = TileSource::open(out_).value();
  auto scratch = tessera::TemporaryFolder::make().value();
  Pass pass(source, {{true, {"c", AttributeType::u8}}}, scratch.path(), {.threads = GetParam().threads});
  std::atomic<int> taken = 0;
  const auto done =
      pass.run([&](std::size_t, const StoredTile&) -> Result<PassValues> { return error(Errc::usage, "no"); },
               [&](std::size_t, const PassValues&) -> Status {
                 ++taken;
                 return success();
               });
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().where, "no");
  EXPECT_EQ(taken, 0);
}

TEST(Pass, EndsWhenItIsStopped) {
  const TemporaryFolder folder;
  store_sample(folder.path() / "out", sample_tiles(sample_points(Shape::uniform, 2, 100), 2, 2));
  std::stop_source stop;
  stop.request_stop();
  auto scratch = tessera::TemporaryFolder::make().value();
  Pass pass(TileSource::open(folder.path() / "out").value(), {{true, {"c", AttributeType::u8}}}, scratch.path(),
            {.stop = stop.get_token()});
  const auto done = pass.run([](std::size_t, const StoredTile&) -> Result<PassValues> { return PassValues{}; },
                             [](std::size_t, const PassValues&) { return Status(success()); });
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, Errc::interrupted);
}

TEST(Pass, AnOwnerThatDoesNotHaveAVertexIsDamage) {
  auto meshes = sample_tiles(sample_points(Shape::uniform, 2, 200), 2, 3);
  // Tile 2 says of a vertex of tile 0 or 1 that the other one owns it.
  for (std::size_t v = 0; v < meshes[2].owners.size(); ++v) {
    if (meshes[2].owners[v] != TileId{1}) continue;
    meshes[2].owners[v] = TileId{0};
    break;
  }
  const TemporaryFolder folder;
  store_sample(folder.path() / "out", meshes);
  auto scratch = tessera::TemporaryFolder::make().value();
  Pass pass(TileSource::open(folder.path() / "out").value(), {{false, {"v", AttributeType::u8}}}, scratch.path(), {});
  const auto done = pass.run(
      [](std::size_t, const StoredTile& tile) -> Result<PassValues> {
        return PassValues{std::vector<std::byte>(tile.mesh.ids.size())};
      },
      [](std::size_t, const PassValues&) { return Status(success()); });
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, Errc::corrupt) << done.error().where;
}

}  // namespace
}  // namespace tessera::test
