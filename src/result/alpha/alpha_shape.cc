#include "src/result/alpha/alpha_shape.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "src/base/crs/crs.h"
#include "src/base/files/temporary.h"
#include "src/base/json/json_text.h"
#include "src/base/option.h"
#include "src/result/alpha/numbered_shape.h"
#include "src/result/alpha/optimal_radius.h"
#include "src/result/alpha/outlines.h"
#include "src/result/alpha/shape_map.h"
#include "src/result/alpha/shape_ply.h"
#include "src/result/alpha/tile_alpha.h"
#include "src/result/export/ending.h"
#include "src/result/export/output.h"
#include "src/result/store/stamp.h"
#include "src/result/tile_queue.h"
#include "src/result/tile_source.h"

namespace tessera {

namespace fs = std::filesystem;

namespace alpha {
namespace {

// The fractions of the progress for the search and for finding simplices; the rest is for writing.
constexpr double search_part = 0.4, finding_part = 0.8;

// What is made of the tiles.
struct Parts {
  NumberedShape simplices;
  std::optional<Outlines> outlines;  // for polygons, in place of the facets
  std::uint64_t cells = 0;           // in the shape
  std::mutex mutex = {};
};

class Making {
 public:
  Making(TileSource source, const AlphaOptions& options, fs::path scratch, std::stop_token stop)
      : source_(std::move(source)), options_(options), scratch_(std::move(scratch)), stop_(std::move(stop)) {}

  const Manifest& manifest() const { return source_.manifest(); }
  bool is_periodic() const { return source_.period().any(); }
  Status check() const {
    if (options_.radius && !(std::isfinite(*options_.radius) && *options_.radius > 0))
      return error(Errc::usage, option("alpha") + ": must be a radius, finite and above 0");
    if (manifest().region)
      return error(Errc::usage, source_.folder().string() +
                                    ": is a region, where not all cells are known; an alpha shape needs a whole "
                                    "triangulation");
    return success();
  }

  // The given radius, or the one that is found.
  Result<double> radius() {
    if (options_.radius) return *options_.radius;
    begin_ = search_part;
    return optimal_radius(source_, {.scratch = scratch_,
                                    .memory_bytes = options_.memory_bytes,
                                    .threads = options_.threads,
                                    .progress = [&](double done) { tell(search_part * done); },
                                    .stop = stop_});
  }

  // Three eighths of the memory are for sorting, the rest for tiles.
  std::unique_ptr<Parts> parts(bool polygons) const {
    const std::uint64_t eighth = options_.memory_bytes / 8;
    auto parts = std::unique_ptr<Parts>(
        new Parts{NumberedShape(manifest().dimension, scratch_, 2 * eighth, stop_), std::nullopt});
    if (polygons) parts->outlines.emplace(scratch_, eighth, stop_);
    return parts;
  }

  // Looks at all tiles.
  Status find(double radius, Parts& parts) {
    // Neighbours, flags and, in a general shape, the edges of all cells.
    const double tile_factor = options_.general ? 4 : 2;
    return for_each_tile(
        source_,
        {.threads = options_.threads,
         .memory_bytes = options_.memory_bytes / 8 * 5,
         .tile_factor = tile_factor,
         .stop = stop_,
         .progress = [&](double done) { tell(begin_ + (finding_part - begin_) * done); }},
        [&](const TileSource& source, std::size_t index) { return find_in(index, source, radius, parts); });
  }

  void tell(double done) const {
    if (options_.progress) options_.progress(done);
  }

 private:
  Status find_in(std::size_t index, const TileSource& source, double radius, Parts& parts) {
    BOOST_OUTCOME_TRY(tile, source.read(index, {}));
    const TileAlpha found(tile.mesh, source.entry(index).tile, source.period(), radius, stop_);
    const auto take = [&](std::span<const ShapeSimplex> simplices) -> Status {
      const std::lock_guard lock(parts.mutex);
      return parts.simplices.add(simplices);
    };
    if (parts.outlines) {
      const auto outline = outline_of(tile.mesh, found.in());
      if (!outline)
        return error(Errc::corrupt,
                     source.file(index).string() + ": the neighbours of its cells contradict each other");
      const std::lock_guard lock(parts.mutex);
      BOOST_OUTCOME_TRYV(parts.outlines->add(*outline));
    } else {
      BOOST_OUTCOME_TRYV(found.regular_facets(take));
    }
    if (options_.general) {
      BOOST_OUTCOME_TRYV(found.singular_faces(take));
    }
    const std::lock_guard lock(parts.mutex);
    parts.cells += found.main_cells();
    return success();
  }

  TileSource source_;
  const AlphaOptions& options_;
  fs::path scratch_;
  std::stop_token stop_;
  double begin_ = 0;
};

Result<Making> open(const fs::path& out, const AlphaOptions& options, const fs::path& scratch, std::stop_token stop) {
  BOOST_OUTCOME_TRY(source, TileSource::open(out, Periods::known));
  Making making(std::move(source), options, scratch, std::move(stop));
  BOOST_OUTCOME_TRYV(making.check());
  return making;
}

Status check_target(const fs::path& target, const AlphaOptions& options) {
  const std::string ending = exports::ending_of(target);
  if (ending != ".ply" && !ShapeMap::is_map(target))
    return error(Errc::usage, target.string() +
                                  ": will be a PLY, or in 2D a GeoPackage, GeoJSON or FlatGeobuf, so give a name that "
                                  "ends in .ply, .gpkg, .geojson or .fgb");
  if (ending == ".fgb" && options.general)
    return error(Errc::usage, target.string() + ": FlatGeobuf holds one kind of shapes, and " +
                                  option("general", "true") + " asks for several; use .gpkg or .geojson");
  return exports::check_free(target, options.overwrite);
}

void count(AlphaShape& shape, SimplexKind kind) {
  switch (kind) {
    case SimplexKind::facet:
      ++shape.facets;
      break;
    case SimplexKind::singular_facet:
      ++shape.singular_facets;
      break;
    case SimplexKind::singular_edge:
      ++shape.singular_edges;
      break;
    case SimplexKind::singular_vertex:
      ++shape.singular_vertices;
      break;
  }
}

Error empty(const fs::path& out, double radius) {
  return error(Errc::usage, out.string() + ": no cell has a circumradius of at most " + radius_text(radius) +
                                "; give a larger " + option("alpha"));
}

// Passes on to a PLY writer, and counts.
class Counted : public ShapeTaker {
 public:
  Counted(ShapePly& to, AlphaShape& shape) : to_(to), shape_(shape) {}
  Status begin(const ShapeCounts& counts) override {
    shape_.vertices = counts.vertices;
    return to_.begin(counts);
  }
  Status vertex(PointId id, const Point& at) override { return to_.vertex(id, at); }
  Status simplex(SimplexKind kind, std::span<const std::uint64_t> vertices) override {
    count(shape_, kind);
    return to_.simplex(kind, vertices);
  }

 private:
  ShapePly& to_;
  AlphaShape& shape_;
};

Status write_ply(const fs::path& target, const Making& making, const AlphaOptions& options, Parts& parts,
                 AlphaShape& shape) {
  BOOST_OUTCOME_TRY(file, ShapePly::create(target, {.dimension = making.manifest().dimension,
                                                    .general = options.general,
                                                    .ids = making.manifest().points_read,
                                                    .periodic = making.is_periodic(),
                                                    .comment = "alpha shape of the radius " + radius_text(shape.radius),
                                                    .stamp = stamp_of(making.manifest())}));
  Counted counted(*file, shape);
  BOOST_OUTCOME_TRYV(parts.simplices.give(counted));
  BOOST_OUTCOME_TRY(bytes, file->finish());
  shape.bytes = bytes;
  return success();
}

Status write_map(const fs::path& target, const Making& making, const AlphaOptions& options, Parts& parts,
                 AlphaShape& shape) {
  BOOST_OUTCOME_TRY(
      map, ShapeMap::create(target, crs_or_none(making.manifest().crs), stamp_of(making.manifest()), options.general));
  BOOST_OUTCOME_TRYV(parts.outlines->for_each([&](const OutlineRings& rings) -> Status {
    ++shape.polygons;
    shape.holes += rings.size() - 1;
    for (const auto& ring : rings) shape.vertices += ring.size();
    shape.facets = shape.vertices;  // a ring has as many edges as vertices
    return map->polygon(rings);
  }));
  BOOST_OUTCOME_TRYV(parts.simplices.for_each([&](const ShapeSimplex& simplex) -> Status {
    count(shape, simplex.kind);
    return map->singular(simplex);
  }));
  BOOST_OUTCOME_TRY(bytes, map->finish());
  shape.bytes = bytes;
  return success();
}

// Collects the arrays.
class Collector : public ShapeTaker {
 public:
  Collector(AlphaArrays& arrays, int dimension) : arrays_(arrays), dimension_(dimension) {}
  Status begin(const ShapeCounts& counts) override {
    arrays_.ids.reserve(counts.vertices);
    arrays_.points.reserve(counts.vertices * static_cast<std::uint64_t>(dimension_));
    for (std::size_t kind = 0; kind < simplex_kinds; ++kind)
      array(static_cast<SimplexKind>(kind))
          .reserve(counts.simplices[kind] * corners_of(static_cast<SimplexKind>(kind), dimension_));
    return success();
  }
  Status vertex(PointId id, const Point& at) override {
    arrays_.ids.push_back(plain(id).value);
    for (int axis = 0; axis < dimension_; ++axis) arrays_.points.push_back(at[axis]);
    return success();
  }
  Status simplex(SimplexKind kind, std::span<const std::uint64_t> vertices) override {
    auto& to = array(kind);
    to.insert(to.end(), vertices.begin(), vertices.end());
    return success();
  }

 private:
  std::vector<std::uint64_t>& array(SimplexKind kind) {
    switch (kind) {
      case SimplexKind::facet:
        break;
      case SimplexKind::singular_facet:
        return arrays_.singular_facets;
      case SimplexKind::singular_edge:
        return arrays_.singular_edges;
      case SimplexKind::singular_vertex:
        return arrays_.singular_vertices;
    }
    return arrays_.facets;
  }
  AlphaArrays& arrays_;
  int dimension_;
};

}  // namespace
}  // namespace alpha

std::string radius_text(double radius) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.17g", radius);
  return text.data();
}

std::string to_json(const AlphaShape& shape) {
  const nlohmann::ordered_json object{{"event", "alpha"},
                                      {"output", shape.path.string()},
                                      {"radius", shape.radius},
                                      {"searched", shape.searched},
                                      {"general", shape.general},
                                      {"cells", shape.cells},
                                      {"vertices", shape.vertices},
                                      {"facets", shape.facets},
                                      {"singular_facets", shape.singular_facets},
                                      {"singular_edges", shape.singular_edges},
                                      {"singular_vertices", shape.singular_vertices},
                                      {"polygons", shape.polygons},
                                      {"holes", shape.holes},
                                      {"bytes", shape.bytes},
                                      {"note", shape.note}};
  return json_text(object);
}

Result<AlphaShape> write_alpha_shape(const fs::path& out, const fs::path& target, const AlphaOptions& options,
                                     std::stop_token stop) {
  BOOST_OUTCOME_TRYV(alpha::check_target(target, options));
  BOOST_OUTCOME_TRY(making, alpha::open(out, options, exports::folder_of(target), stop));
  const bool polygons = alpha::ShapeMap::is_map(target);
  if (polygons && making.manifest().dimension != 2)
    return error(Errc::usage, target.string() + ": a map holds polygons, and " + out.string() +
                                  " is a 3D result; give a name that ends in .ply");
  if (polygons && making.is_periodic())
    return error(Errc::usage, target.string() +
                                  ": a polygon has an inside and an outside, which the shape of a periodic "
                                  "cloud need not have; give a name that ends in .ply");
  AlphaShape shape{.path = target, .searched = !options.radius, .general = options.general};
  if (polygons) shape.note = crs_note(making.manifest().crs);
  BOOST_OUTCOME_TRY(radius, making.radius());
  shape.radius = radius;
  const auto parts = making.parts(polygons);
  BOOST_OUTCOME_TRYV(making.find(radius, *parts));
  shape.cells = parts->cells;
  if (shape.cells == 0 && !options.general) return alpha::empty(out, radius);
  BOOST_OUTCOME_TRYV(polygons ? alpha::write_map(target, making, options, *parts, shape)
                              : alpha::write_ply(target, making, options, *parts, shape));
  making.tell(1);
  return shape;
}

Result<AlphaArrays> make_alpha_shape(const fs::path& out, const AlphaOptions& options, std::stop_token stop) {
  BOOST_OUTCOME_TRY(scratch, folder_for_temporary());
  BOOST_OUTCOME_TRY(making, alpha::open(out, options, scratch, stop));
  AlphaArrays arrays;
  BOOST_OUTCOME_TRY(radius, making.radius());
  arrays.radius = radius;
  const auto parts = making.parts(false);
  BOOST_OUTCOME_TRYV(making.find(radius, *parts));
  arrays.cells = parts->cells;
  alpha::Collector collector(arrays, making.manifest().dimension);
  BOOST_OUTCOME_TRYV(parts->simplices.give(collector));
  return arrays;
}

}  // namespace tessera
