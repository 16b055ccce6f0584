#include "src/result/measure/measure.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <mutex>
#include <nlohmann/json.hpp>
#include <numeric>
#include <span>
#include <utility>

#include "src/base/crs/survey_system.h"
#include "src/base/files/free_space.h"
#include "src/base/json/json_text.h"
#include "src/base/option.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "src/result/measure/exact_volume.h"
#include "src/result/new_version.h"
#include "src/result/pass.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t cells_a_look = 4096;  // between two checks for a stop

std::string unit_of(const Manifest& manifest) {
  const CoordinateUnits units = coordinate_units(manifest.crs);
  if (units.horizontal.empty() || (manifest.dimension == 3 && units.vertical != units.horizontal)) return "";
  return units.horizontal + "^" + std::to_string(manifest.dimension);
}

template <class Number>
std::vector<std::byte> as_bytes(const std::vector<Number>& numbers) {
  const auto bytes = std::as_bytes(std::span(numbers));
  return {bytes.begin(), bytes.end()};
}

// For own vertices, the sum over the cells around, from the least value to the greatest, so that the order of the cells
// does not matter. Zero for other vertices.
std::vector<double> stars_of(const TileMesh& mesh, const std::vector<double>& volumes) {
  const std::size_t corners = static_cast<std::size_t>(mesh.dimension) + 1;
  const auto is_own = [&](std::int32_t v) { return mesh.point_ghost[static_cast<std::size_t>(v)] == 0; };
  // Collects the cells around each vertex by a counting sort.
  std::vector<std::uint32_t> first(mesh.points.size() + 1, 0);
  for (const std::int32_t v : mesh.cells) first[static_cast<std::size_t>(v) + 1] += is_own(v) ? 1 : 0;
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<std::uint32_t> around(first.back());
  std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
  for (std::size_t i = 0; i < mesh.cells.size(); ++i)
    if (is_own(mesh.cells[i]))
      around[next[static_cast<std::size_t>(mesh.cells[i])]++] = static_cast<std::uint32_t>(i / corners);
  std::vector<double> stars(mesh.points.size(), 0), values;
  for (std::size_t v = 0; v < stars.size(); ++v) {
    values.clear();
    for (std::uint32_t i = first[v]; i < first[v + 1]; ++i) values.push_back(volumes[around[i]]);
    std::sort(values.begin(), values.end());
    stars[v] = std::accumulate(values.begin(), values.end(), 0.0);
  }
  return stars;
}

class Volumes {
 public:
  Volumes(const TileSource& source, std::stop_token stop) : source_(source), stop_(std::move(stop)) {}

  Result<PassValues> of(std::size_t index, const StoredTile& tile) {
    const TileMesh& mesh = tile.mesh;
    const std::size_t corners = static_cast<std::size_t>(mesh.dimension) + 1;
    const unsigned factorial = mesh.dimension == 2 ? 2 : 6;
    std::vector<double> volumes(mesh.cell_ghost.size());
    ExactSum sum;
    std::uint64_t infinite = 0;
    std::array<Point, 4> at;
    for (std::size_t cell = 0; cell < volumes.size(); ++cell) {
      if (cell % cells_a_look == 0 && stop_.stop_requested())
        return error(Errc::interrupted, "interrupted while measuring");
      for (std::size_t k = 0; k < corners; ++k)
        at[k] = mesh.points[static_cast<std::size_t>(mesh.cells[cell * corners + k])];
      const ScaledInteger exact = volume_times_factorial(std::span(at).first(corners));
      if (exact.value <= 0)
        return error(Errc::corrupt,
                     source_.file(index).string() + ": cell " + std::to_string(cell) + " is not positively oriented");
      volumes[cell] = rounded_quotient(exact, factorial);
      if (mesh.cell_ghost[cell] != 0) continue;
      sum.add(exact);
      infinite += std::isinf(volumes[cell]) ? 1 : 0;
    }
    const auto stars = stars_of(mesh, volumes);
    for (const double star : stars) infinite += std::isinf(star) ? 1 : 0;
    const std::lock_guard lock(mutex_);
    sum_.add(sum);
    infinite_ += infinite;
    return PassValues{as_bytes(volumes), as_bytes(stars)};
  }

  double total() const { return rounded_quotient(sum_.value(), source_.manifest().dimension == 2 ? 2 : 6); }
  std::uint64_t infinite() const { return infinite_; }

 private:
  const TileSource& source_;
  std::stop_token stop_;
  std::mutex mutex_;
  ExactSum sum_;
  std::uint64_t infinite_ = 0;
};

Measured begin_of(const fs::path& out, const Manifest& manifest) {
  Measured measured;
  measured.folder = out;
  measured.version = manifest.version;
  measured.of_cells = manifest.dimension == 2 ? "area" : "volume";
  measured.of_vertices = "star_" + measured.of_cells;
  measured.unit = unit_of(manifest);
  if (manifest.region)
    measured.note = manifest.region->complete
                        ? "the result is a region: around a vertex, only the cells that meet the region count"
                        : "the result is a region that is not complete: cells that are not final, and the cells around "
                          "vertices, may "
                          "differ in the whole triangulation";
  return measured;
}

// True if the columns exist already. Error usage when something else has their names.
Result<bool> is_measured(const fs::path& out, const Manifest& manifest, Measured& measured) {
  const auto column = [&](const std::string& name) {
    return std::find_if(manifest.columns.begin(), manifest.columns.end(),
                        [&](const ResultColumn& one) { return one.name == name; });
  };
  const auto of_cells = column(measured.of_cells), of_vertices = column(measured.of_vertices),
             none = manifest.columns.end();
  if (of_cells != none && of_vertices != none && of_cells->of_cells && !of_vertices->of_cells && of_cells->total) {
    measured.made = false;
    measured.total = *of_cells->total;
    measured.unit = of_cells->unit;
    return true;
  }
  for (const auto& attribute : manifest.schema)
    if (attribute.name == measured.of_vertices)
      return error(Errc::usage, out.string() + ": its vertices have an attribute '" + attribute.name +
                                    "' already; triangulate without " + "it, or under another name");
  if (of_cells != none) return error(Errc::usage, out.string() + ": has a column '" + measured.of_cells + "' already");
  return false;
}

std::vector<ResultColumn> columns_of(const Measured& measured, const MeasureOptions& options) {
  ResultColumn column{.name = measured.of_cells,
                      .of_cells = true,
                      .type = AttributeType::f64,
                      .unit = measured.unit,
                      .command = options.command,
                      .software_version = options.software_version};
  std::vector<ResultColumn> columns{column};
  column.name = measured.of_vertices;
  column.of_cells = false;
  columns.push_back(std::move(column));
  return columns;
}

}  // namespace

Result<Measured> measure(const fs::path& out, const MeasureOptions& options, std::stop_token stop) {
  if (!options.volume)
    return error(Errc::usage, "there is nothing to measure; " + option("volume", "true") + " measures cells");
  // Also when the columns exist: this removes what an ended writer has left, and older versions.
  BOOST_OUTCOME_TRY(next, NewVersion::begin(out));
  const TileSource& source = next->source();
  Measured measured = begin_of(out, source.manifest());
  BOOST_OUTCOME_TRY(there, is_measured(out, source.manifest(), measured));
  if (there) return measured;

  auto columns = columns_of(measured, options);
  std::vector<PassColumn> passed;
  for (const auto& column : columns) passed.push_back({column.of_cells, {column.name, column.type}});
  Volumes volumes(source, stop);
  // A tile as a mesh, and the cells around its vertices.
  Pass pass(source, passed, next->scratch(),
            {.threads = options.threads,
             .memory_bytes = options.memory_bytes,
             .tile_factor = 2.25,
             .stop = stop,
             .progress = options.progress});
  BOOST_OUTCOME_TRYV(next->check_room(columns, pass.scratch_bytes(), known_free_bytes(out)));
  BOOST_OUTCOME_TRYV(
      pass.run([&](std::size_t index, const StoredTile& tile) { return volumes.of(index, tile); },
               [&](std::size_t index, const PassValues& values) {
                 const store::ColumnValues made[] = {{true, passed[0].as, values[0]}, {false, passed[1].as, values[1]}};
                 return next->add_columns(index, made, stop);
               }));
  measured.total = volumes.total();
  measured.infinite = volumes.infinite();
  measured.version = next->number();
  if (measured.infinite > 0)
    measured.note += std::string(measured.note.empty() ? "" : "; ") + std::to_string(measured.infinite) +
                     " values of cells and vertices are beyond what a double holds, and stored as infinite";
  columns.front().total = measured.total;
  BOOST_OUTCOME_TRYV(next->commit(std::move(columns)));
  return measured;
}

std::string to_json(const Measured& measured) {
  using Json = nlohmann::ordered_json;
  const Json object{{"event", "measured"},
                    {"output", measured.folder.string()},
                    {"version", measured.version},
                    {"made", measured.made},
                    {"columns", {measured.of_cells, measured.of_vertices}},
                    {"total", std::isfinite(measured.total) ? Json(measured.total) : Json()},
                    {"unit", measured.unit},
                    {"infinite", measured.infinite},
                    {"note", measured.note}};
  return json_text(object);
}

}  // namespace tessera
