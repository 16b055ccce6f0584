#include "tests/store/sample_result.h"

#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <limits>
#include <random>
#include <set>
#include <sstream>

#include "src/geometry/kernel/kernel.h"
#include "src/result/store/points_tile.h"

namespace tessera::test {

std::vector<Point> sample_points(Shape shape, int dimension, std::size_t n, unsigned seed) {
  std::mt19937_64 random(seed);
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  std::set<Point> points;
  if (shape == Shape::lattice) {
    const int side = static_cast<int>(std::ceil(std::pow(static_cast<double>(n), 1.0 / dimension)));
    for (int x = 0; x < side; ++x)
      for (int y = 0; y < side; ++y)
        for (int z = 0; z < (dimension == 3 ? side : 1); ++z)
          points.insert({static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)});
  }
  while (points.size() < n) {
    Point p{unit(), unit(), dimension == 3 ? unit() : 0.0};
    if (shape == Shape::terrain) {
      p = {std::round(p.x * 200) / 10, std::round(p.y * 200) / 10, dimension == 3 ? std::round(p.z * 8) / 10 : 0.0};
    } else if (shape == Shape::sphere) {
      const Point c{p.x - 0.5, p.y - 0.5, dimension == 3 ? p.z - 0.5 : 0.0};
      const double r = std::sqrt(c.x * c.x + c.y * c.y + c.z * c.z);
      if (r < 0.01) continue;
      p = {std::round(c.x / r * 1e6), std::round(c.y / r * 1e6), std::round(c.z / r * 1e6)};
    }
    points.insert(without_negative_zero(p));
  }
  std::vector<Point> result(points.begin(), points.end());
  std::shuffle(result.begin(), result.end(), random);
  return result;
}

std::vector<TileMesh> sample_tiles(const std::vector<Point>& points, int dimension, std::uint32_t tiles) {
  std::vector<double> xs;
  for (const auto& p : points) xs.push_back(p.x);
  std::sort(xs.begin(), xs.end());
  std::vector<std::uint32_t> tile_of(points.size(), 0);
  for (std::size_t i = 0; i < points.size(); ++i)
    while (tile_of[i] + 1 < tiles && points[i].x >= xs[xs.size() * (tile_of[i] + 1) / tiles]) ++tile_of[i];
  return sample_tiles(points, dimension, tiles, [&](std::size_t i) { return tile_of[i]; });
}

std::vector<TileMesh> sample_tiles(const std::vector<Point>& points, int dimension, std::uint32_t tiles,
                                   const std::function<std::uint32_t(std::size_t)>& tile_of) {
  const auto kernel = make_kernel(dimension);
  kernel->build(points);
  const CellList all = kernel->cells();
  const std::size_t corners = static_cast<std::size_t>(dimension) + 1;
  std::vector<TileMesh> meshes(tiles);
  for (std::uint32_t tile = 0; tile < tiles; ++tile) {
    TileMesh& mesh = meshes[tile];
    mesh.dimension = dimension;
    // By point and by place in `all`: the number in the mesh. Clouds of some tests are large.
    constexpr std::int32_t not_here = -1;
    std::vector<std::int32_t> number(points.size(), not_here), cell_number(all.vertices.size() / corners, not_here);
    std::vector<std::size_t> cells;
    std::vector<bool> seen(points.size(), false);
    for (std::size_t c = 0; c < cell_number.size(); ++c) {
      const Vertex* cell = all.vertices.data() + c * corners;
      if (std::find(cell, cell + corners, infinite_vertex) != cell + corners) continue;
      if (std::none_of(cell, cell + corners, [&](Vertex v) { return tile_of(v - 1) == tile; })) continue;
      cell_number[c] = static_cast<std::int32_t>(cells.size());
      cells.push_back(c);
      for (std::size_t k = 0; k < corners; ++k) seen[cell[k] - 1] = true;
    }
    for (const bool foreign : {false, true})
      for (std::size_t point = 0; point < points.size(); ++point) {
        // Own points that no cell has are there, too: tests rely on what they put in.
        if ((tile_of(point) == tile) == foreign || (foreign && !seen[point])) continue;
        number[point] = static_cast<std::int32_t>(mesh.points.size());
        mesh.points.push_back(points[point]);
        mesh.ids.push_back({point});
        mesh.owners.push_back({tile_of(point)});
        mesh.point_ghost.push_back(foreign ? 1 : 0);
      }
    for (const std::size_t c : cells) {
      std::uint32_t lowest = tiles;
      for (std::size_t k = 0; k < corners; ++k) {
        const std::size_t point = all.vertices[c * corners + k] - 1;
        lowest = std::min(lowest, tile_of(point));
        mesh.cells.push_back(number[point]);
        const std::size_t beyond = all.neighbors[c * corners + k];
        const Vertex* other = all.vertices.data() + beyond * corners;
        mesh.neighbors.push_back(std::find(other, other + corners, infinite_vertex) != other + corners ? -1
                                 : cell_number[beyond] != not_here ? cell_number[beyond]
                                                                   : -2);
      }
      mesh.cell_ghost.push_back(lowest == tile ? 0 : 1);
    }
  }
  return meshes;
}

namespace {

// Tiles that are slabs are cut off one after the other.
void set_splits(Manifest& manifest) {
  std::ostringstream text;
  text << std::setprecision(17) << R"({"kind": ")" << manifest.partition_kind << R"(", "dimension": )"
       << manifest.dimension << R"(, "tiles": )" << manifest.boxes.size() << R"(, "splits": [)";
  const std::size_t splits = manifest.partition_kind == "random" ? 0 : manifest.boxes.size() - 1;
  for (std::size_t i = 0; i < splits; ++i) {
    const auto above = i + 1 < splits ? static_cast<std::ptrdiff_t>(i) + 1 : -2 - static_cast<std::ptrdiff_t>(i);
    text << (i > 0 ? ", " : "") << "[0, " << manifest.boxes[i].hi.x << ", " << -1 - static_cast<std::ptrdiff_t>(i)
         << ", " << above << "]";
  }
  manifest.partition = text.str() + "]}";
}

// The boxes of tiles that are slabs along x; all of space for each, as a random partition has, when they are not.
void set_partition(const std::vector<TileMesh>& meshes, Manifest& manifest) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  manifest.partition_kind = "kdtree";
  manifest.boxes.assign(meshes.size(), Box{});
  double next = inf;
  for (std::size_t tile = meshes.size(); tile-- > 0;) {
    double lo = next, hi = -inf;
    for (std::size_t i = 0; i < meshes[tile].points.size(); ++i) {
      if (meshes[tile].point_ghost[i] != 0) continue;
      lo = std::min(lo, meshes[tile].points[i].x);
      hi = std::max(hi, meshes[tile].points[i].x);
    }
    if (hi >= next) {
      manifest.partition_kind = "random";
      manifest.boxes.assign(meshes.size(), Box{});
      break;
    }
    if (lo == next) lo = std::nextafter(next, -inf);  // an empty tile has room, too
    manifest.boxes[tile].hi.x = next;
    if (tile > 0) manifest.boxes[tile].lo.x = next = lo;
  }
  set_splits(manifest);
}

}  // namespace

namespace {

Result<TileEntry> write_as_points(const std::filesystem::path& out, TileId tile, const TileMesh& mesh,
                                  std::span<const std::byte> rows, const StoreOptions& options) {
  const auto is_main = [](std::uint8_t ghost) { return ghost == 0; };
  CountedCells counted;
  counted.cells = mesh.cell_ghost.size();
  counted.main_cells = static_cast<std::uint64_t>(std::ranges::count_if(mesh.cell_ghost, is_main));
  counted.digest = CellDigest(mesh.dimension, mesh.ids).of(mesh.cells, mesh.cell_ghost.data());
  return write_points_tile(out,
                           {.dimension = mesh.dimension,
                            .tile = tile,
                            .own = static_cast<std::uint64_t>(std::ranges::count_if(mesh.point_ghost, is_main)),
                            .points = mesh.points,
                            .ids = mesh.ids,
                            .owners = mesh.owners,
                            .schema = options.schema,
                            .rows = rows},
                           counted, options);
}

}  // namespace

Manifest store_sample(const std::filesystem::path& out, const std::vector<TileMesh>& meshes,
                      const StoreOptions& options, const std::vector<DuplicatePair>& duplicates, const RowsOf& rows_of,
                      const std::function<TileKind(TileId)>& kind_of) {
  Manifest manifest;
  manifest.software_version = "0.1.0";
  manifest.command = {"tessera", "triangulate", "cloud.xyz"};
  manifest.dimension = meshes.front().dimension;
  set_partition(meshes, manifest);
  manifest.neighbors = options.neighbors;
  manifest.schema = options.schema;
  for (std::uint32_t tile = 0; tile < meshes.size(); ++tile) {
    const TileMesh& mesh = meshes[tile];
    if (mesh.points.empty()) continue;
    std::vector<std::byte> rows(mesh.points.size() * row_bytes(options.schema));
    for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = static_cast<std::byte>(i * 7);
    if (rows_of) rows = rows_of(mesh);
    const bool as_points = kind_of && kind_of(TileId{tile}) == TileKind::points;
    const auto entry = as_points ? write_as_points(out, TileId{tile}, mesh, rows, options)
                                 : write_tile(out, TileId{tile}, mesh, rows, options);
    EXPECT_TRUE(entry) << (entry ? "" : entry.error().where);
    if (!entry) return manifest;
    manifest.tiles.push_back(entry.value());
    manifest.vertices += entry.value().own_points;
    manifest.cells += entry.value().main_cells;
    for (const auto& p : mesh.points) manifest.bounds.add(p);
  }
  manifest.duplicates = duplicates.size();
  manifest.points_read = manifest.vertices + duplicates.size();
  const auto status = finish_store(out, manifest, duplicates);
  EXPECT_TRUE(status) << (status ? "" : status.error().where);
  return manifest;
}

TemporaryFolder::TemporaryFolder() {
  // In memory where there is such a place: on a disk, syncing takes five times as long as all the rest of these tests.
  const std::filesystem::path memory = "/dev/shm";
  std::error_code code;
  const bool usable = std::filesystem::is_directory(memory, code) && ::access(memory.c_str(), W_OK) == 0;
  std::string name = ((usable ? memory : std::filesystem::temp_directory_path()) / "tessera-test-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot make " + name);
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code code;
  std::filesystem::remove_all(path_, code);
}

}  // namespace tessera::test
