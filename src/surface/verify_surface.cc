#include "src/surface/verify_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "src/base/files/folder.h"
#include "src/base/files/names.h"
#include "src/base/files/temporary.h"
#include "src/base/files/there.h"
#include "src/base/json/json_text.h"
#include "src/result/store/external_sort.h"
#include "src/result/version_log.h"
#include "src/surface/build.h"
#include "src/surface/mesh_file.h"

namespace tessera {

namespace fs = std::filesystem;

namespace surface {
namespace {

// One use of an edge by a triangle.
struct EdgeUse {
  std::array<PointId, 2> edge;  // ascending
  std::int32_t direction = 0;   // 1 from the first to the second, else -1
  friend bool operator<(const EdgeUse& a, const EdgeUse& b) { return a.edge < b.edge; }
};

enum class From : std::uint8_t { file, triangulation };

// The least vertex is first; the order round the triangle is kept.
struct TriangleUse {
  std::array<PointId, 3> corners;
  From from = From::file;
  friend bool operator<(const TriangleUse& a, const TriangleUse& b) { return a.corners < b.corners; }
};

struct VertexUse {
  PointId id;
  Point at;
  From from = From::file;
  friend bool operator<(const VertexUse& a, const VertexUse& b) { return a.id < b.id; }
};

TriangleUse use_of(std::array<PointId, 3> corners, From from) {
  std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
  return {corners, from};
}

std::string text_of(const std::array<PointId, 3>& corners) {
  return to_string(corners[0]) + "-" + to_string(corners[1]) + "-" + to_string(corners[2]);
}

Result<std::vector<fs::path>> files_of(const fs::path& mesh) {
  BOOST_OUTCOME_TRY(folder, is_folder(mesh));
  if (!folder) return std::vector<fs::path>{mesh};
  std::vector<fs::path> files;
  FolderReader reader(mesh);
  while (const char* name = reader.next())
    if (fs::path(name).extension() == ".ply") files.push_back(mesh / name);
  if (reader.error()) return io_error(mesh, "cannot be listed", reader.error().value());
  std::ranges::sort(files);
  return files;
}

class Check {
 public:
  Check(fs::path mesh, const VerifySurfaceOptions& options, StepsRunner& runner, std::stop_token stop)
      : mesh_(std::move(mesh)),
        options_(options),
        runner_(runner),
        stop_(std::move(stop)),
        edges_(options.scratch, options.memory_bytes / 4, stop_),
        triangles_(options.scratch, options.memory_bytes / 4, stop_),
        vertices_(options.scratch, options.memory_bytes / 4, stop_) {}

  Result<SurfaceReport> run() {
    BOOST_OUTCOME_TRYV(read());
    BOOST_OUTCOME_TRYV(check_edges());
    if (!options_.triangulation) {
      report_.note =
          "not checked, because it needs the triangulation: that the triangles are facets of the triangulation, and "
          "that the cut is a minimum";
      return std::move(report_);
    }
    BOOST_OUTCOME_TRYV(make_again());
    BOOST_OUTCOME_TRYV(compare_triangles());
    BOOST_OUTCOME_TRYV(compare_vertices());
    return std::move(report_);
  }

 private:
  Error wrong(const std::string& what) const { return error(Errc::not_delaunay, mesh_.string() + ": " + what); }
  bool may_end() const {
    return recipe_ && (recipe_->options.trim || recipe_->options.bottom == SurfaceOptions::Bottom::open);
  }

  Status read() {
    BOOST_OUTCOME_TRY(files, files_of(mesh_));
    for (const fs::path& path : files) {
      BOOST_OUTCOME_TRY(file, MeshFile::open(path));
      if (&path == &files.front()) recipe_ = file.recipe();
      BOOST_OUTCOME_TRYV(file.for_each_vertex([&](PointId id, const Point& at) {
        return vertices_.push({id, at, From::file});
      }));
      BOOST_OUTCOME_TRYV(file.for_each_triangle([&](const std::array<PointId, 3>& corners) -> Status {
        for (std::size_t k = 0; k < 3; ++k) {
          const PointId a = corners[k], b = corners[(k + 1) % 3];
          BOOST_OUTCOME_TRYV(edges_.push({{std::min(a, b), std::max(a, b)}, a < b ? 1 : -1}));
        }
        return triangles_.push(use_of(corners, From::file));
      }));
      report_.triangles += file.triangles();
    }
    return success();
  }

  Status check_edges() {
    const bool manifold = recipe_ && recipe_->options.manifold;
    std::uint64_t edges = 0, uses = 0;
    std::int64_t sum = 0;
    std::array<PointId, 2> edge{};
    const auto end = [&]() -> Status {
      if (uses == 0) return success();
      ++edges;
      const std::string name = "edge " + to_string(edge[0]) + "-" + to_string(edge[1]);
      if (sum != 0) {
        ++report_.ends;
        if (!may_end()) return wrong("is not closed: at " + name + " triangles on one side lack those on the other");
      }
      if (manifold && uses > 2)
        return wrong("is not manifold: " + name + " has " + std::to_string(uses) + " triangles");
      return success();
    };
    BOOST_OUTCOME_TRYV(edges_.for_each([&](const EdgeUse& use) -> Status {
      if (use.edge != edge) {
        BOOST_OUTCOME_TRYV(end());
        edge = use.edge;
        uses = 0;
        sum = 0;
      }
      ++uses;
      sum += use.direction;
      return success();
    }));
    BOOST_OUTCOME_TRYV(end());
    report_.passed.push_back(report_.ends == 0
                                 ? "closed: each of its " + std::to_string(edges) +
                                       " edges has as many triangles on both sides"
                                 : "ends at " + std::to_string(report_.ends) + " edges, as its options let it");
    if (manifold) report_.passed.push_back("manifold: no edge has more than two triangles");
    return success();
  }

  Status make_again() {
    if (!recipe_) return error(Errc::usage, mesh_.string() + ": has no comment on how the surface was made");
    BOOST_OUTCOME_TRY(source, TileSource::open(*options_.triangulation));
    const Manifest& manifest = source.manifest();
    if (!manifest.digest || digest_text(*manifest.digest) != recipe_->triangulation)
      return another_triangulation(source);
    SurfaceOptions options = recipe_->options;
    BOOST_OUTCOME_TRY(sensors, options_.sensors(recipe_->sensors));
    options.sensors = std::move(sensors);
    options.memory_bytes = options_.memory_bytes / 4;
    options.threads = options_.threads;
    BOOST_OUTCOME_TRYV(check_surface_options(options));
    BOOST_OUTCOME_TRY(scratch, TemporaryFolder::make(temporary_name_of_process(options_.scratch / "surface")));
    BOOST_OUTCOME_TRY(built,
                      build(source, options, {.run = scratch.path(), .lock_file = {}}, true, runner_, {}, stop_));
    report_.passed.push_back("made again: " + std::to_string(manifest.cells) +
                             " cells, and their smallest minimum cut is proved by its flow");
    BOOST_OUTCOME_TRY(made, TileSource::open(built.triangles));
    Point corner{};
    if (options.output.local)
      corner = {std::floor(made.manifest().bounds.lo.x), std::floor(made.manifest().bounds.lo.y), 0};
    for (std::size_t i = 0; i < made.tiles(); ++i) {
      BOOST_OUTCOME_TRY(tile, made.read(i, {.rows = true}));
      BOOST_OUTCOME_TRYV(take(tile, corner));
    }
    return success();
  }

  // Names the version that the surface was made of, if it can be found.
  Error another_triangulation(const TileSource& source) const {
    std::string sentence =
        options_.triangulation->string() + ": is another triangulation than " + mesh_.string() + " was made of";
    const auto told = tell_versions(source.folder());
    for (const ToldVersion& version : told ? told.value().versions : std::vector<ToldVersion>()) {
      if (!version.entry.digest || digest_text(*version.entry.digest) != recipe_->triangulation) continue;
      sentence += "; it was made of version " + std::to_string(version.entry.version) + " of this result";
      if (!version.readable) sentence += ", which is not kept any more";
      break;
    }
    return error(Errc::usage, std::move(sentence));
  }

  Status take(const StoredTile& tile, const Point& corner) {
    const TileMesh& mesh = tile.mesh;
    const std::size_t width = row_bytes(tile.schema);
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
      if (mesh.point_ghost[v] != 0) continue;
      Point at = mesh.points[v];
      std::memcpy(&at.z, tile.rows.data() + v * width, sizeof at.z);
      BOOST_OUTCOME_TRYV(
          vertices_.push({mesh.ids[v], {at.x - corner.x, at.y - corner.y, at.z - corner.z}, From::triangulation}));
    }
    for (std::size_t i = 0; i < mesh.cell_ghost.size(); ++i) {
      if (mesh.cell_ghost[i] != 0) continue;
      const auto id = [&](std::size_t k) { return PointId{mesh.ids[static_cast<std::size_t>(mesh.cells[3 * i + k])]}; };
      BOOST_OUTCOME_TRYV(triangles_.push(use_of({id(0), id(1), id(2)}, From::triangulation)));
    }
    return success();
  }

  Status compare_triangles() {
    const auto same = [](const TriangleUse& a, const TriangleUse& b) { return a.corners == b.corners; };
    BOOST_OUTCOME_TRYV(for_each_group(triangles_, 3, same, [&](std::span<const TriangleUse> uses) -> Status {
      const auto here = std::ranges::count(uses, From::file, &TriangleUse::from);
      const std::string name = "triangle " + text_of(uses[0].corners);
      if (here > 1) return wrong("has " + name + " more than once");
      if (here == std::ranges::ssize(uses)) return wrong("has " + name + ", which is no part of the surface");
      if (here == 0) return wrong("lacks " + name);
      return success();
    }));
    report_.passed.push_back("its " + std::to_string(report_.triangles) +
                             " triangles are those between inside and outside, each once");
    return success();
  }

  // With a file for each tile, a file has vertices of other tiles, too.
  Status compare_vertices() {
    std::optional<VertexUse> first;
    bool here = false, there = false;
    const auto end = [&]() -> Status {
      if (!first) return success();
      ++report_.vertices;
      if (!here) return wrong("lacks vertex " + to_string(first->id));
      if (!there) return wrong("has vertex " + to_string(first->id) + ", which is no part of the surface");
      return success();
    };
    BOOST_OUTCOME_TRYV(vertices_.for_each([&](const VertexUse& use) -> Status {
      if (!first || first->id != use.id) {
        BOOST_OUTCOME_TRYV(end());
        first = use;
        here = there = false;
      }
      if (use.at != first->at) return wrong("vertex " + to_string(use.id) + " is not where it should be");
      (use.from == From::file ? here : there) = true;
      return success();
    }));
    BOOST_OUTCOME_TRYV(end());
    report_.passed.push_back("its " + std::to_string(report_.vertices) + " vertices are where they should be");
    return success();
  }

  fs::path mesh_;
  const VerifySurfaceOptions& options_;
  StepsRunner& runner_;
  std::stop_token stop_;
  std::optional<Recipe> recipe_;
  ExternalSort<EdgeUse> edges_;
  ExternalSort<TriangleUse> triangles_;
  ExternalSort<VertexUse> vertices_;
  SurfaceReport report_;
};

}  // namespace
}  // namespace surface

Result<bool> is_surface(const fs::path& path) {
  BOOST_OUTCOME_TRY(folder, is_folder(path));
  if (!folder) return path.extension() == ".ply";
  BOOST_OUTCOME_TRY(result, is_there(manifest_file(path)));
  if (result) return false;
  auto files = surface::files_of(path);
  return files && !files.value().empty();
}

Result<SurfaceReport> verify_surface(const fs::path& mesh, const VerifySurfaceOptions& options,
                                     surface::StepsRunner& runner, const std::stop_token& stop) {
  return surface::Check(mesh, options, runner, stop).run();
}

std::string to_json(const SurfaceReport& report, const std::string& mesh) {
  using Json = nlohmann::ordered_json;
  const Json object{{"event", "verified"},         {"surface", mesh},     {"triangles", report.triangles},
                    {"vertices", report.vertices}, {"ends", report.ends}, {"passed", report.passed},
                    {"note", report.note}};
  return json_text(object);
}

}  // namespace tessera
