#include "src/result/measure/measure.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "src/base/crs/survey_system.h"
#include "src/base/files/free_space.h"
#include "src/base/json/json_text.h"
#include "src/base/option.h"
#include "src/result/measure/tile_measure.h"
#include "src/result/measure/values.h"
#include "src/result/new_version.h"
#include "src/result/pass.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

using Measures = std::vector<std::unique_ptr<TileMeasure>>;

std::string note_of(const Manifest& manifest) {
  if (!manifest.region) return "";
  return manifest.region->complete
             ? "the result is a region: around a vertex, only the cells that meet the region count"
             : "the result is a region that is not complete: cells that are not final, and the cells around vertices, "
               "may differ in the whole triangulation";
}

// Tells of the volumes, from the columns of the result.
void tell_total(const Manifest& manifest, Measured& measured) {
  for (const ResultColumn& column : manifest.columns) {
    if (column.name != "volume" && column.name != "area") continue;
    measured.total = column.total;
    measured.total_of = column.name;
    measured.unit = column.unit;
  }
}

Status run(NewVersion& next, Measures& measures, std::vector<ResultColumn>& columns, const MeasureOptions& options,
           const std::stop_token& stop) {
  const fs::path out = next.source().folder();
  std::vector<PassColumn> passed;
  for (const auto& column : columns) passed.push_back({column.of_cells, {column.name, column.type}});
  // A tile as a mesh, perhaps twice, the cells around its vertices, and values.
  Pass pass(next.source(), passed, next.scratch(),
            {.threads = options.threads,
             .memory_bytes = options.memory_bytes,
             .tile_factor = options.voronoi || options.density ? 3.5 : 2.25,
             .stop = stop,
             .progress = options.progress});
  BOOST_OUTCOME_TRYV(next.check_room(columns, pass.scratch_bytes(), known_free_bytes(out)));
  return pass.run(
      [&](std::size_t index, const StoredTile& tile) { return values_of(measures, next.source(), index, tile, stop); },
      [&](std::size_t index, const PassValues& values) {
        std::vector<store::ColumnValues> made;
        for (std::size_t i = 0; i < passed.size(); ++i) made.push_back({passed[i].of_cells, passed[i].as, values[i]});
        return next.add_columns(index, made, stop);
      });
}

}  // namespace

Result<PassValues> values_of(const Measures& measures, const TileSource& source, std::size_t index,
                             const StoredTile& tile, const std::stop_token& stop) {
  std::vector<std::unique_ptr<CellValues>> of_cells;
  bool any = false;
  for (const auto& measure : measures) {
    of_cells.push_back(measure->cells_of(tile.mesh));
    any = any || of_cells.back();
  }
  if (any) {
    BOOST_OUTCOME_TRYV(
        for_each_cell(source, index, tile.mesh, stop,
                      [&](std::size_t cell, std::span<const std::int32_t> vertices, const ScaledInteger& exact) {
                        for (const auto& one : of_cells)
                          if (one) one->take(cell, vertices, exact);
                      }));
  }
  PassValues all;
  for (std::size_t i = 0; i < measures.size(); ++i) {
    BOOST_OUTCOME_TRY(values, of_cells[i] ? Result<PassValues>(of_cells[i]->finish()) : measures[i]->of(index, tile));
    for (auto& each : values) all.push_back(std::move(each));
  }
  return all;
}

std::string unit_of(const Manifest& manifest, int exponent) {
  const CoordinateUnits units = coordinate_units(manifest.crs);
  if (units.horizontal.empty() || (manifest.dimension == 3 && units.vertical != units.horizontal)) return "";
  return units.horizontal + (exponent == 1 ? "" : "^" + std::to_string(exponent));
}

Status check_measure_options(const MeasureOptions& options) {
  if (!options.density && !options.mass.empty())
    return error(Errc::usage, option("mass") + ": has no effect without " + option("density", "true"));
  if (options.volume || options.quality || options.voronoi || options.density) return success();
  return error(Errc::usage, "there is nothing to measure; " + option("volume", "true") + " and " +
                                option("quality", "true") + " measure cells, " + option("voronoi", "true") +
                                " measures the Voronoi cells of vertices, " + option("density", "true") +
                                " the densities of vertices");
}

namespace {

// Adds a remark to a note.
void remark(std::string& note, const std::string& more) {
  if (!more.empty()) note += (note.empty() ? "" : "; ") + more;
}

// Finishes the columns of each measure, and adds what there is to say of their values.
void finish(const Measures& measures, std::vector<ResultColumn>& columns, Measured& measured) {
  auto begin = columns.begin();
  for (const auto& one : measures) {
    const auto end = begin + static_cast<std::ptrdiff_t>(one->columns().size());
    std::vector<ResultColumn> own(begin, end);
    one->finish(own);
    begin = std::copy(own.begin(), own.end(), begin);
    measured.infinite += one->infinite();
    remark(measured.note, one->note());
  }
  if (measured.infinite > 0)
    remark(measured.note, std::to_string(measured.infinite) +
                              " values of cells and vertices are beyond what a double holds, and stored as infinite");
}

}  // namespace

Result<Measured> measure(const fs::path& out, const MeasureOptions& options, std::stop_token stop) {
  BOOST_OUTCOME_TRYV(check_measure_options(options));
  // Also when the columns exist: this removes what an ended writer has left, and older versions.
  BOOST_OUTCOME_TRY(next, NewVersion::begin(out, {.lock = options.lock, .keep = {}, .periods = Periods::known}));
  const Manifest& manifest = next->source().manifest();
  if ((options.voronoi || options.density) && manifest.region)
    return error(Errc::usage, out.string() + ": is a region, where not all cells around a vertex are known; " +
                                  (options.voronoi ? "Voronoi cells" : "densities") + " need a whole triangulation");
  Measured measured;
  measured.folder = out;
  measured.version = manifest.version;
  measured.note = note_of(manifest);
  measured.made = false;
  Measures wanted, missing;
  if (options.volume) wanted.push_back(measure_volumes(next->source()));
  if (options.quality) wanted.push_back(measure_quality(next->source()));
  if (options.voronoi) wanted.push_back(measure_voronoi(next->source(), stop));
  if (options.density) {
    BOOST_OUTCOME_TRY(density, measure_density(next->source(), options.mass, options.memory_bytes, stop));
    wanted.push_back(std::move(density));
  }
  std::vector<ResultColumn> columns;
  for (auto& one : wanted) {
    const auto own = one->columns();
    for (const auto& column : own) measured.columns.push_back({column.name, column.of_cells});
    BOOST_OUTCOME_TRY(there, next->has_columns(own));
    if (there) continue;
    columns.insert(columns.end(), own.begin(), own.end());
    missing.push_back(std::move(one));
  }
  if (options.volume) tell_total(manifest, measured);
  if (missing.empty()) return measured;

  for (ResultColumn& column : columns) {
    column.command = options.command;
    column.software_version = options.software_version;
  }
  BOOST_OUTCOME_TRYV(run(*next, missing, columns, options, stop));
  finish(missing, columns, measured);
  measured.made = true;
  measured.version = next->number();
  if (options.volume) {
    Manifest told;
    told.columns = columns;
    tell_total(told, measured);
  }
  BOOST_OUTCOME_TRYV(next->commit(
      std::move(columns), {.inputs = {}, .command = options.command, .software_version = options.software_version}));
  return measured;
}

std::string to_json(const Measured& measured) {
  using Json = nlohmann::ordered_json;
  Json names = Json::array(), of_cells = Json::array();
  for (const auto& column : measured.columns) {
    names.push_back(column.name);
    if (column.of_cells) of_cells.push_back(column.name);
  }
  const bool finite = measured.total && std::isfinite(*measured.total);
  const Json object{{"event", "measured"},
                    {"output", measured.folder.string()},
                    {"version", measured.version},
                    {"made", measured.made},
                    {"columns", std::move(names)},
                    {"columns_of_cells", std::move(of_cells)},
                    {"total", finite ? Json(*measured.total) : Json()},
                    {"total_of", measured.total_of},
                    {"unit", measured.unit},
                    {"infinite", measured.infinite},
                    {"note", measured.note}};
  return json_text(object);
}

}  // namespace tessera
