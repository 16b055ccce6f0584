#include "tests/update/update_testing.h"

#include <utility>
#include <vector>

#include "src/geometry/reference/reference.h"
#include "src/job/engine_steps.h"
#include "src/result/tile_source.h"
#include "src/result/verify/verify.h"

namespace tessera::testing {

Result<Updated> update_here(const fs::path& result, const ResultChange& change, const UpdateOptions& options,
                            std::stop_token stop, std::uint64_t memory_bytes) {
  Engine engine(options.threads, memory_bytes, kinds_of_stages());
  Progress progress;
  EngineStages stages(engine, {.threads = options.threads, .memory_bytes = memory_bytes}, progress);
  return update_result(result, change, options, stages, std::move(stop));
}

// Tile by tile the same as what is made of the points that are left; files of cells byte for byte.
void Update::expect_as_from_scratch() const {
  const test::TemporaryFolder scratch;
  const Manifest expected = cloud_.store(scratch.path() / "out");
  const auto opened = TileSource::open(now());
  ASSERT_TRUE(opened) << opened.error().where;
  const TileSource& source = opened.value();
  const Manifest& got = source.manifest();
  EXPECT_EQ(got.digest, expected.digest);
  EXPECT_EQ(got.vertices, expected.vertices);
  EXPECT_EQ(got.cells, expected.cells);
  EXPECT_EQ(got.duplicates, expected.duplicates);
  EXPECT_EQ(got.points_read, expected.points_read);
  EXPECT_EQ(got.filtered, expected.filtered);
  EXPECT_EQ(got.bounds, expected.bounds);
  EXPECT_EQ(got.duplicates_xxh3, expected.duplicates_xxh3);
  EXPECT_EQ(got.duplicate_rows_xxh3, expected.duplicate_rows_xxh3);
  ASSERT_EQ(got.tiles.size(), expected.tiles.size());
  std::vector<TileMesh> meshes;
  for (std::size_t i = 0; i < got.tiles.size(); ++i) {
    TileEntry entry = got.tiles[i];
    // foreign vertices of points may be in another order; a tile that had no file is of any kind
    if (entry.kind == TileKind::points || entry.kind != expected.tiles[i].kind) {
      entry.kind = expected.tiles[i].kind;
      entry.bytes = expected.tiles[i].bytes;
      entry.xxh3 = expected.tiles[i].xxh3;
    }
    EXPECT_EQ(entry, expected.tiles[i]) << "tile " << to_string(entry.tile);
    auto tile = source.read(i, {.cells = true, .rows = !cloud_.schema.empty()});
    ASSERT_TRUE(tile) << tile.error().where;
    if (!cloud_.schema.empty()) {
      EXPECT_EQ(tile.value().rows, cloud_.rows_of(tile.value().mesh.ids));
    }
    meshes.push_back(std::move(tile.value().mesh));
  }
  if (cloud_.keep == DuplicatePolicy::first) {
    EXPECT_EQ(difference(global_delaunay(cloud_.points, cloud_.dimension), main_cells(meshes)), "");
  }
  const auto verified = verify(now(), {}, {});
  EXPECT_TRUE(verified) << verified.error().where;
}

}  // namespace tessera::testing
