#include "src/result/tileset/tileset.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "src/base/files/folder.h"
#include "src/base/files/free_space.h"
#include "src/base/files/names.h"
#include "src/base/files/temporary.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/base/json/json_text.h"
#include "src/base/option.h"
#include "src/result/export/cell_filter.h"
#include "src/result/tile_source.h"
#include "src/result/tileset/columns.h"
#include "src/result/tileset/node_files.h"
#include "src/result/tileset/surface.h"
#include "src/tiling/partition.h"

namespace tessera {

namespace fs = std::filesystem;

namespace tileset {
namespace {

// In units of the coordinates, from the origin: 32-bit floats can hold this, with room for products.
constexpr double farthest = 1e15;

// A part of the surface whose file is written. It is kept as long as its parent needs it.
struct Built {
  Surface surface;
  std::size_t place = 0;
};

class Making {
 public:
  Making(const TileSource& source, const Partition& partition, const TilesetOptions& options,
         const std::stop_token& stop, NodeFiles& files)
      : source_(source),
        manifest_(source.manifest()),
        partition_(partition),
        options_(options),
        stop_(stop),
        files_(files),
        filter_({options.max_edge, options.max_radius}),
        heights_(find_column(manifest_.schema, "z")),
        intensities_(find_column(manifest_.schema, "intensity")),
        classes_(find_column(manifest_.schema, "classification")),
        closed_(options.surface_of.has_value()) {}

  // The parts of all tiles below this row of the partition, or of this leaf; empty when they have no triangles.
  Result<std::vector<Built>> build(std::int32_t row) {
    std::vector<Built> parts;
    if (row < 0) {
      BOOST_OUTCOME_TRY(surface, load(tile_at(row)));
      if (surface.triangles() == 0) return parts;
      BOOST_OUTCOME_TRY(built, divide(std::move(surface)));
      parts.push_back(std::move(built));
      return parts;
    }
    // Two levels of splits at a time, so that a node has four children.
    for (const std::int32_t half : partition_.splits()[static_cast<std::size_t>(row)].child) {
      std::vector<std::int32_t> below{half};
      if (half >= 0) {
        const SplitNode& split = partition_.splits()[static_cast<std::size_t>(half)];
        below.assign(std::begin(split.child), std::end(split.child));
      }
      for (const std::int32_t child : below) {
        BOOST_OUTCOME_TRY(built, build(child));
        for (Built& part : built) parts.push_back(std::move(part));
      }
    }
    if (parts.size() < 2) return parts;
    BOOST_OUTCOME_TRY(joined, combine(std::move(parts)));
    std::vector<Built> one;
    one.push_back(std::move(joined));
    return one;
  }

  std::uint64_t triangles() const { return triangles_; }
  std::uint64_t left_out() const { return left_out_; }

 private:
  Result<Surface> load(TileId id) {
    const auto index = source_.find(id);
    if (!index) return Surface{};  // the tile has no points
    BOOST_OUTCOME_TRY(tile, source_.stopped_by(stop_).read(*index, {.rows = true}));
    const TileMesh& mesh = tile.mesh;
    const std::size_t row = row_bytes(manifest_.schema);
    Surface surface;
    std::vector<std::int64_t> number(mesh.points.size(), -1);
    for (std::size_t cell = 0; cell < mesh.cell_ghost.size(); ++cell) {
      if (mesh.cell_ghost[cell] != 0) continue;
      ++done_;
      if (!filter_.keeps(mesh, cell)) {
        ++left_out_;
        continue;
      }
      for (std::size_t k = 0; k < 3; ++k) {
        const auto v = static_cast<std::size_t>(mesh.cells[3 * cell + k]);
        if (number[v] < 0) {
          number[v] = static_cast<std::int64_t>(surface.vertices.size());
          const std::byte* values = tile.rows.data() + v * row;
          Point at = mesh.points[v];
          at.z = heights_.at(values);
          if (!(std::abs(at.z) <= farthest))
            return error(Errc::usage, source_.folder().string() +
                                          ": a vertex has a height that cannot be shown: " + std::to_string(at.z));
          surface.vertices.push_back({at, mesh.ids[v], mesh.owners[v], clamped<std::uint16_t>(intensities_.at(values)),
                                      clamped<std::uint8_t>(classes_.at(values))});
        }
        surface.corners.push_back(static_cast<std::uint32_t>(number[v]));
      }
    }
    triangles_ += surface.triangles();
    return surface;
  }

  Result<Built> divide(Surface surface) {
    if (surface.triangles() <= options_.node_triangles) return add(std::move(surface), 0, {});
    std::vector<Surface> quarters = tileset::quarters(surface, closed_ ? 3 : 2);
    surface = {};
    std::vector<Built> parts;
    for (Surface& quarter : quarters) {
      BOOST_OUTCOME_TRY(part, divide(std::exchange(quarter, {})));
      parts.push_back(std::move(part));
    }
    return combine(std::move(parts));
  }

  Result<Built> combine(std::vector<Built> parts) {
    std::vector<const Surface*> surfaces;
    std::vector<std::size_t> children;
    double below = 0;
    for (const Built& part : parts) {
      surfaces.push_back(&part.surface);
      children.push_back(part.place);
      below = std::max(below, files_.nodes()[part.place].error);
    }
    const Surface fine = join(surfaces);
    parts.clear();
    Surface coarse = simplify(fine, options_.node_triangles);
    const double step = closed_ ? distance_error(fine, coarse) : height_error(fine, coarse);
    return add(std::move(coarse), below + step, std::move(children));
  }

  Result<Built> add(Surface surface, double error, std::vector<std::size_t> children) {
    if (stop_.stop_requested()) return tessera::error(Errc::interrupted, "interrupted while making the tileset");
    BOOST_OUTCOME_TRY(place, files_.add(surface, error, std::move(children)));
    if (options_.progress)
      options_.progress(static_cast<double>(done_) / static_cast<double>(std::max<std::uint64_t>(manifest_.cells, 1)));
    return Built{std::move(surface), place};
  }

  const TileSource& source_;
  const Manifest& manifest_;
  const Partition& partition_;
  const TilesetOptions& options_;
  std::stop_token stop_;
  NodeFiles& files_;
  exports::CellFilter filter_;
  Column heights_, intensities_, classes_;
  bool closed_;
  std::uint64_t done_ = 0, triangles_ = 0, left_out_ = 0;  // cells
};

Result<bool> is_tileset(const fs::path& folder) {
  BOOST_OUTCOME_TRY(document, is_regular(tileset_file(folder)));
  if (!document) return false;
  return is_folder(tileset_nodes_folder(folder));
}

Status check_place(const fs::path& target, bool overwrite) {
  BOOST_OUTCOME_TRY(there, is_there(target, FollowLinks::no));
  if (!there) return success();
  BOOST_OUTCOME_TRY(folder, is_folder(target));
  if (folder) {
    BOOST_OUTCOME_TRY(empty, is_empty_folder(target));
    if (empty) return success();
  }
  if (!overwrite)
    return error(Errc::usage, target.string() + ": exists already; " + option("overwrite", "true") + " replaces it");
  BOOST_OUTCOME_TRY(replaceable, is_tileset(target));
  if (!replaceable) return error(Errc::usage, target.string() + ": is not a tileset, so it is not replaced");
  return success();
}

Status check_result(const fs::path& out, const Manifest& manifest) {
  if (manifest.dimension != 2)
    return error(Errc::usage,
                 out.string() + ": is a 3D result, which is no surface; triangulate with " + option("dim", "2"));
  const Bounds& box = manifest.bounds;
  if (!(box.hi.x - box.lo.x <= farthest && box.hi.y - box.lo.y <= farthest))
    return error(Errc::usage, out.string() + ": its points are too far apart for the 32-bit floats of viewers");
  return success();
}

// Memory for a tile as it is stored, as a surface, its parts, and for joining and simplifying.
std::uint64_t tile_memory(const TileSource& source, std::size_t i) {
  const TileEntry& tile = source.entry(i);
  return source.work_bytes(i) * 5 / 4 + tile.points * 120 + tile.cells * 40;
}

Status check_room(const TileSource& source, const fs::path& folder, std::uint64_t memory_bytes) {
  const fs::path& out = source.folder();
  const Manifest& manifest = source.manifest();
  for (std::size_t i = 0; i < source.tiles(); ++i)
    if (const std::uint64_t memory = tile_memory(source, i); memory > memory_bytes)
      return error(Errc::memory, out.string() + ": tile " + to_string(source.entry(i).tile) + " needs " +
                                     std::to_string((memory >> 20) + 1) + " MiB of memory: give more " +
                                     option("memory") + ", or triangulate with less " + option("max-points-per-tile"));
  return tessera::check_room(folder, "the tileset", tileset_bytes(manifest), known_free_bytes(folder));
}

}  // namespace
}  // namespace tileset

// All levels together have 4/3 of the triangles, and a triangle takes 3 to 8 bytes.
std::uint64_t tileset_bytes(const Manifest& manifest) { return manifest.cells * 11; }

std::string to_json(const Tileset& tileset) {
  using Json = nlohmann::ordered_json;
  const Json object{{"event", "tileset"},       {"output", tileset.path.string()}, {"nodes", tileset.nodes},
                    {"leaves", tileset.leaves}, {"triangles", tileset.triangles},  {"left_out", tileset.left_out},
                    {"bytes", tileset.bytes}};
  return json_text(object);
}

Status check_tileset_target(const fs::path& target, bool overwrite) {
  return tileset::check_place(target.has_filename() ? target : target.parent_path(), overwrite);
}

Status check_tileset_partition(const fs::path& out, const std::string& partition) {
  BOOST_OUTCOME_TRY(read, Partition::from_json(partition));
  if (read.kind() != PartitionKind::random) return success();
  return error(Errc::usage, out.string() + ": its tiles do not lie side by side; triangulate without " +
                                option("partition", "random"));
}

Result<Tileset> write_tileset(const fs::path& out, const fs::path& target, const TilesetOptions& options,
                              std::stop_token stop) {
  const fs::path path = target.has_filename() ? target : target.parent_path();
  BOOST_OUTCOME_TRYV(tileset::check_place(path, options.overwrite));
  BOOST_OUTCOME_TRYV(exports::check_sizes({options.max_edge, options.max_radius}));
  BOOST_OUTCOME_TRY(source, TileSource::open(out));
  const Manifest& manifest = source.manifest();
  BOOST_OUTCOME_TRYV(tileset::check_result(out, manifest));
  const std::string tree = options.surface_of.value_or(manifest.partition);
  BOOST_OUTCOME_TRYV(check_tileset_partition(out, tree));
  BOOST_OUTCOME_TRY(partition, Partition::from_json(tree));
  const fs::path beside = path.has_parent_path() ? path.parent_path() : fs::path(".");
  BOOST_OUTCOME_TRYV(make_directories(beside));
  BOOST_OUTCOME_TRYV(tileset::check_room(source, beside, options.memory_bytes));
  BOOST_OUTCOME_TRY(folder, TemporaryFolder::make(temporary_name_of_process(path)));
  BOOST_OUTCOME_TRY(files, tileset::NodeFiles::create(folder.path(), manifest.bounds));
  tileset::Making making(source, partition, options, stop, files);
  BOOST_OUTCOME_TRY(roots, making.build(partition.splits().empty() ? as_leaf(TileId{0}) : 0));
  if (roots.empty())
    return error(
        Errc::usage,
        out.string() + ": there are no triangles to show" +
            (making.left_out() > 0 ? "; all exceed " + option("max-edge") + " or " + option("max-radius") : ""));
  BOOST_OUTCOME_TRYV(files.finish(roots.front().place, manifest));
  BOOST_OUTCOME_TRYV(sync_folder(folder.path()));
  if (const auto failed = remove_tree(path)) return io_error(path, "cannot be replaced", failed.value());
  BOOST_OUTCOME_TRYV(rename_file(folder.path(), path));
  folder.keep();
  BOOST_OUTCOME_TRYV(sync_folder(beside));
  const auto leaves = std::count_if(files.nodes().begin(), files.nodes().end(),
                                    [](const tileset::TilesetNode& node) { return node.children.empty(); });
  return Tileset{.path = path,
                 .nodes = files.nodes().size(),
                 .leaves = static_cast<std::uint64_t>(leaves),
                 .triangles = making.triangles(),
                 .left_out = making.left_out(),
                 .bytes = files.bytes()};
}

}  // namespace tessera
