// bench_points_file [--points n] [--tiles n] [--seed n] [file...]: tiles as files of points, of made-up clouds and of
// those given: bytes a vertex, by column, and what writing and reading take, on one thread, in memory, best of 3
// passes. Uniform points are in 3D, with ids in random order; terrain and files in 2D with z as attribute, once with
// ids in the order of the cloud and once in random order. A tile's foreign vertices are those next to its box, about as
// many as the triangulation has there. Default: 10000000 points, 27 tiles, seed 7.
#include <time.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <map>
#include <numeric>
#include <random>
#include <string>
#include <variant>
#include <vector>

#include "src/base/option.h"
#include "src/base/random.h"
#include "src/input/cloud/cloud.h"
#include "src/input/generate/generate.h"
#include "src/result/store/integer_block.h"
#include "src/result/store/points_file.h"
#include "src/tiling/partition.h"
#include "src/tiling/routed_cloud.h"

namespace tessera {
namespace {

// What this thread has had of a processor: other programs may be busy.
double processor_seconds() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

struct Points {
  int dimension = 3;
  std::vector<LocalPoint> points;  // ids are places
  std::vector<Attribute> schema;
  std::vector<std::byte> rows;
};

Points made_up(CloudShape shape, std::uint64_t n, std::uint64_t seed) {
  Points made{shape == CloudShape::uniform ? 3 : 2, {}, {}, {}};
  if (made.dimension == 2) made.schema = {{"z", AttributeType::f64}};
  PointGenerator generator({.shape = shape, .points = n, .seed = seed});
  std::vector<Point> batch;
  std::vector<std::uint8_t> classes;
  for (generator.next(batch, classes); !batch.empty(); generator.next(batch, classes))
    for (Point p : batch) {
      if (made.dimension == 2) {
        const auto* z = reinterpret_cast<const std::byte*>(&p.z);
        made.rows.insert(made.rows.end(), z, z + sizeof p.z);
        p.z = 0;
      }
      made.points.push_back({without_negative_zero(p), {made.points.size()}});
    }
  return made;
}

// Numbers of 64 random bits from [0, 1), which lie on no grid.
Points off_the_grid(std::uint64_t n, std::uint64_t seed) {
  Points made;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  const auto any = [&] { return unit(random) * (0.75 + unit(random) / 4); };
  for (std::uint64_t i = 0; i < n; ++i) made.points.push_back({{any(), any(), any()}, {i}});
  return made;
}

Result<Points> of_file(const std::string& path, const std::vector<std::string>& attributes) {
  BOOST_OUTCOME_TRY(cloud, Cloud::open({path}, {.dimension = 2, .attributes = attributes}));
  Points read{2, {}, cloud.schema(), {}};
  BOOST_OUTCOME_TRYV(cloud.for_each_batch([&](CloudBatch& batch) -> Status {
    for (const LocalPoint& p : batch.points) read.points.push_back({p.at, {read.points.size()}});
    read.rows.insert(read.rows.end(), batch.rows.begin(), batch.rows.end());
    return success();
  }));
  return read;
}

// The vertices of each tile. `number_of`: ids, by place.
std::vector<PointsTile> tiles_of(const Points& cloud, std::uint32_t tiles,
                                 const std::vector<std::uint64_t>& number_of) {
  Bounds bounds;
  std::vector<Point> sample;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    bounds.add(cloud.points[i].at);
    if (i % (cloud.points.size() / 1'000'000 + 1) == 0) sample.push_back(cloud.points[i].at);
  }
  const auto partition = Partition::build_tiles(PartitionKind::kdtree, cloud.dimension, sample, bounds, tiles);
  double volume = 1;
  for (int axis = 0; axis < cloud.dimension; ++axis) volume *= bounds.hi[axis] - bounds.lo[axis];
  const double reach = std::pow(volume / static_cast<double>(cloud.points.size()), 1.0 / cloud.dimension);

  std::vector<std::vector<LocalPoint>> own(tiles), foreign(tiles);
  for (const LocalPoint& p : cloud.points)
    for (std::uint32_t t = 0; t < tiles; ++t) {
      const Box& box = partition.boxes()[t];
      double off = 0;
      for (int axis = 0; axis < cloud.dimension; ++axis)
        off = std::max({off, box.lo[axis] - p.at[axis], p.at[axis] - box.hi[axis]});
      if (off <= reach) (box.contains(p.at) ? own : foreign)[t].push_back(p);
    }

  const std::size_t stride = row_bytes(cloud.schema);
  std::vector<PointsTile> made(tiles);
  for (std::uint32_t t = 0; t < tiles; ++t) {
    PointsTile& tile = made[t];
    const LoadedTile ordered = order_points(own[t], cloud.dimension);
    tile.dimension = cloud.dimension;
    tile.tile = TileId{t};
    tile.own = ordered.points.size();
    tile.schema = cloud.schema;
    const auto add = [&](const Point& at, PointId place) {
      tile.points.push_back(at);
      tile.ids.push_back({number_of[place.value]});
      tile.owners.push_back(partition.tile_of(at));
      const auto row = cloud.rows.begin() + static_cast<std::ptrdiff_t>(place.value * stride);
      tile.rows.insert(tile.rows.end(), row, row + static_cast<std::ptrdiff_t>(stride));
    };
    for (std::size_t i = 0; i < ordered.points.size(); ++i) add(ordered.points[i], ordered.ids[i]);
    std::ranges::sort(foreign[t], {}, [&](const LocalPoint& p) { return number_of[p.id.value]; });
    for (const LocalPoint& p : foreign[t]) add(p.at, p.id);
  }
  return made;
}

double best_of_3(const auto& work) {
  double best = 1e300;
  for (int pass = 0; pass < 3; ++pass) {
    const double begin = processor_seconds();
    work();
    best = std::min(best, processor_seconds() - begin);
  }
  return best;
}

bool equal(const PointsTile& a, const PointsTile& b) {
  const auto same = [](const auto& x, const auto& y) {
    return x.size() == y.size() && std::memcmp(x.data(), y.data(), x.size() * sizeof x[0]) == 0;
  };
  return same(a.points, b.points) && same(a.ids, b.ids) && same(a.owners, b.owners) && same(a.rows, b.rows);
}

bool measure(const std::string& name, const std::vector<PointsTile>& tiles) {
  std::vector<BigVector<std::byte>> files(tiles.size());
  std::vector<PointsTile> read(tiles.size());
  std::uint64_t vertices = 0, own = 0, bytes = 0;
  const auto each = [&](const auto& work) {
    return best_of_3([&] {
      for (std::size_t t = 0; t < tiles.size(); ++t) work(t);
    });
  };
  const double written_s = each([&](std::size_t t) { files[t] = points_file_bytes(view_of(tiles[t])); });
  const double read_s =
      each([&](std::size_t t) { read[t] = parse_points_file(files[t], name, tiles[t].tile).value(); });
  std::map<std::string, std::uint64_t> of_column;
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    if (!equal(read[t], tiles[t])) {
      std::fprintf(stderr, "%s: tile %zu is not what was written\n", name.c_str(), t);
      return false;
    }
    vertices += tiles[t].points.size();
    own += tiles[t].own;
    bytes += files[t].size();
    const auto head = std::get<store::PointsHead>(store::parse_points_head(files[t], files[t].size()));
    for (const auto& column : head.columns())
      for (std::uint64_t b = column.first_block; b < column.first_block + column.blocks; ++b)
        of_column[head.place(column)] += head.blocks[b].bytes;
  }
  const auto n = static_cast<double>(vertices);
  std::printf("%-44s %10llu vertices, %4.1f %% foreign  %6.2f bytes  written %5.1f ns  read %5.1f ns a vertex\n",
              name.c_str(), static_cast<unsigned long long>(vertices), 100 - 100 * static_cast<double>(own) / n,
              static_cast<double>(bytes) / n, written_s / n * 1e9, read_s / n * 1e9);
  for (const auto& [column, size] : of_column) {
    const double rows = column.starts_with("own") ? static_cast<double>(own) : n - static_cast<double>(own);
    std::printf("    %-40s %6.2f bytes a row\n", column.c_str(), static_cast<double>(size) / rows);
  }
  return true;
}

bool measure(const std::string& name, const Points& cloud, std::uint32_t tiles, std::uint64_t seed, bool in_order) {
  std::vector<std::uint64_t> number_of(cloud.points.size());
  std::iota(number_of.begin(), number_of.end(), std::uint64_t{0});
  if (in_order && !measure(name + ", ids in order", tiles_of(cloud, tiles, number_of))) return false;
  std::shuffle(number_of.begin(), number_of.end(), std::mt19937_64(seed));
  return measure(name + ", ids at random", tiles_of(cloud, tiles, number_of));
}

Status run(std::uint64_t points, std::uint32_t tiles, std::uint64_t seed, const std::vector<std::string>& files,
           const std::vector<std::string>& attributes) {
  const Error differs = error(Errc::internal, "what was read is not what was written");
  if (points > 0) {
    std::printf("%llu points, %u tiles, seed %llu, blocks of %zu rows\n", static_cast<unsigned long long>(points),
                tiles, static_cast<unsigned long long>(seed), store::block_rows);
    if (!measure("uniform", made_up(CloudShape::uniform, points, seed), tiles, seed, false)) return differs;
    if (!measure("off the grid", off_the_grid(points, seed), tiles, seed, false)) return differs;
    if (!measure("terrain, 2D", made_up(CloudShape::terrain, points, seed), tiles, seed, true)) return differs;
  }
  for (const std::string& file : files) {
    BOOST_OUTCOME_TRY(cloud, of_file(file, attributes));
    const auto enough = static_cast<std::uint32_t>(cloud.points.size() / 300'000 + 1);
    if (!measure(file.substr(file.rfind('/') + 1) + ", 2D", cloud, enough, seed, true)) return differs;
  }
  return success();
}

}  // namespace
}  // namespace tessera

int main(int argc, char** argv) {
  std::uint64_t points = 10'000'000, seed = 7;
  std::uint32_t tiles = 27;
  std::vector<std::string> files, attributes;
  CLI::App app("Bytes and time that tiles take as files of points");
  app.add_option("--points", points, "to make up; 0 for none");
  app.add_option("--tiles", tiles, "of made-up clouds")->check(CLI::Range(1, 1'000'000));
  app.add_option("--seed", seed, "of clouds, and of the order of ids");
  app.add_option("--attributes", attributes, "of files, to carry besides z; all for all")
      ->delimiter(',')
      ->allow_extra_args(false);
  app.add_option("files", files, "to measure besides");
  CLI11_PARSE(app, argc, argv);
  const auto status = tessera::run(points, tiles, seed, files, attributes);
  if (status.has_error())
    std::fprintf(stderr, "bench_points_file: %s\n", tessera::in_plain_words(status.error().where).c_str());
  return status.has_error() ? 1 : 0;
}
