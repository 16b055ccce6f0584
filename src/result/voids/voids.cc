#include "src/result/voids/voids.h"

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "src/base/files/free_space.h"
#include "src/base/json/json_text.h"
#include "src/base/option.h"
#include "src/result/measure/measure.h"
#include "src/result/measure/tile_measure.h"
#include "src/result/new_version.h"
#include "src/result/voids/densities.h"
#include "src/result/voids/watershed.h"

namespace tessera::voids {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view by_volume = "voronoi", by_points = "density", by_mass = "density_";

// The part of the progress for columns that are missing.
constexpr double columns_part = 0.5;

std::function<void(double)> part_of(const VoidsOptions& options, double from, double to) {
  if (!options.progress) return {};
  return [&options, from, to](double done) { options.progress(from + (to - from) * done); };
}

// Computes the columns that the densities need. Returns whether any was missing.
Result<bool> measure_missing(const fs::path& out, const VoidsOptions& options, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(source, TileSource::open(out, Periods::known));
  const Manifest& manifest = source.manifest();
  MeasureOptions missing{.voronoi = !Densities::has_column(manifest, Densities::volume_column(manifest.dimension)),
                         .density = options.by != by_volume && !Densities::has_column(manifest, options.by),
                         .memory_bytes = options.memory_bytes,
                         .threads = options.threads,
                         .command = options.command,
                         .software_version = options.software_version,
                         .lock = options.lock,
                         .progress = part_of(options, 0, columns_part)};
  if (!missing.voronoi && !missing.density) return false;
  if (missing.density && options.by.starts_with(by_mass)) missing.mass = options.by.substr(by_mass.size());
  BOOST_OUTCOME_TRYV(measure(out, missing, stop));
  return true;
}

double rounded(const OrderFreeSum& sum) { return sum.value().value(); }

VoidTable table_of(Watershed& watershed, const Densities& densities, int dimension) {
  VoidTable table{.dimension = dimension, .rows = {}};
  const std::vector<Void> voids = watershed.graph().voids();
  const std::vector<Zone>& zones = watershed.graph().zones();
  for (std::size_t i = 0; i < zones.size(); ++i) {
    const Zone& zone = zones[i];
    const Void& found = voids[i];
    // All that are connected flood the deepest zone, up to the highest density.
    const Level out = found.saddle.value_or(*watershed.highest());
    VoidRow row{.core = zone.core.vertex,
                .place = zone.place,
                .core_density = densities.density(zone.core.value),
                .zone_points = zone.points,
                .zone_volume = rounded(zone.volume),
                .zones = found.zones,
                .points = found.points,
                .volume = rounded(found.volume),
                .saddle = {},
                .saddle_density = densities.density(out.value),
                .parent = found.parent,
                .contrast = densities.contrast(zone.core.value, out.value)};
    if (found.saddle) row.saddle = found.saddle->vertex;
    row.probability = void_probability(row.contrast, dimension);
    table.rows.push_back(row);
  }
  return table;
}

std::vector<std::byte> column_values(const Watershed& watershed, std::span<const ZoneNumber> zones) {
  std::vector<std::int64_t> values(zones.size(), -1);
  for (std::size_t v = 0; v < zones.size(); ++v)
    if (zones[v] != no_zone)
      values[v] = static_cast<std::int64_t>(watershed.graph().zones()[zones[v]].core.vertex.value);
  const auto bytes = std::as_bytes(std::span(values));
  return {bytes.begin(), bytes.end()};
}

Result<std::unique_ptr<ZonesByPoint>> zones_by_point(const NewVersion& next, const fs::path& target) {
  if (files_of(target).size() == 1) return std::unique_ptr<ZonesByPoint>();
  BOOST_OUTCOME_TRY(duplicates, next.source().read_duplicates());
  return std::make_unique<ZonesByPoint>(next.scratch(), std::move(duplicates), next.source().manifest().points_read);
}

// One search: over the tiles of a version, which is being changed if it lacks the column.
class Search {
 public:
  Search(NewVersion& next, const VoidsOptions& options, std::stop_token stop)
      : next_(next), options_(options), stop_(std::move(stop)) {}

  Result<FoundVoids> run(double progress_from) {
    const TileSource& source = next_.source();
    const Manifest& manifest = source.manifest();
    BOOST_OUTCOME_TRY(densities, Densities::open(source, options_.by, options_.memory_bytes));
    const ResultColumn column{.name = options_.by == by_volume ? "zone" : "zone_" + options_.by,
                              .of_cells = false,
                              .type = AttributeType::i64,
                              .unit = "",
                              .command = options_.command,
                              .software_version = options_.software_version};
    BOOST_OUTCOME_TRY(has_column, next_.has_columns(std::span(&column, 1)));
    if (!options_.target.empty()) {
      BOOST_OUTCOME_TRY(points, zones_by_point(next_, options_.target));
      points_ = std::move(points);
    }
    Watershed watershed(source, densities, next_.scratch(),
                        {.threads = options_.threads,
                         .memory_bytes = options_.memory_bytes,
                         .stop = stop_,
                         .progress = part_of(options_, progress_from, 1)});
    if (!has_column) {
      BOOST_OUTCOME_TRYV(
          next_.check_room(std::span(&column, 1), watershed.scratch_bytes(), known_free_bytes(source.folder())));
    }
    BOOST_OUTCOME_TRYV(watershed.run([&](std::size_t index, const TileFlow& flow, std::span<const ZoneNumber> zones) {
      return take(watershed, has_column ? nullptr : &column, index, flow, zones);
    }));
    FoundVoids result{.found = {.folder = source.folder(),
                                .version = manifest.version,
                                .made = !has_column,
                                .column = column.name,
                                .zones = watershed.graph().zones().size(),
                                .points = 0,
                                .outside = watershed.vertices_outside(),
                                .files = {},
                                .unit = unit_of(manifest, manifest.dimension)},
                      .table = table_of(watershed, densities, manifest.dimension)};
    for (const VoidRow& row : result.table.rows) result.found.points += row.zone_points;
    BOOST_OUTCOME_TRYV(finish(result, column));
    return result;
  }

 private:
  Status take(const Watershed& watershed, const ResultColumn* column, std::size_t index, const TileFlow& flow,
              std::span<const ZoneNumber> zones) {
    if (points_) {
      std::vector<PointId> own;
      std::vector<ZoneNumber> of_own;
      for (std::size_t v = 0; v < zones.size(); ++v) {
        if (flow.is_foreign[v] != 0) continue;
        own.push_back(flow.ids[flow.nodes[v]]);
        of_own.push_back(zones[v]);
      }
      BOOST_OUTCOME_TRYV(points_->add(own, of_own));
    }
    if (column == nullptr) return success();
    const auto values = column_values(watershed, zones);
    const store::ColumnValues one{false, {column->name, column->type}, values};
    return next_.add_columns(index, std::span(&one, 1), stop_);
  }

  // Writes the files, makes the new version, and gives the files their names.
  Status finish(FoundVoids& result, const ResultColumn& column) {
    std::vector<OutputFile> files;
    if (!options_.target.empty()) {
      BOOST_OUTCOME_TRY(written, write_voids(result.table, options_.target, points_.get()));
      files = std::move(written);
      result.found.files = files_of(options_.target);
    }
    if (stop_.stop_requested()) return error(Errc::interrupted, "interrupted while looking for voids");
    if (result.found.made) {
      result.found.version = next_.number();
      BOOST_OUTCOME_TRYV(next_.commit(
          {column}, {.inputs = {}, .command = options_.command, .software_version = options_.software_version}));
    }
    for (OutputFile& file : files) {
      BOOST_OUTCOME_TRYV(file.commit());
    }
    return success();
  }

  NewVersion& next_;
  const VoidsOptions& options_;
  std::stop_token stop_;
  std::unique_ptr<ZonesByPoint> points_;
};

}  // namespace

Status check_voids_options(const VoidsOptions& options) {
  if (options.by != by_volume && options.by != by_points &&
      !(options.by.starts_with(by_mass) && options.by.size() > by_mass.size()))
    return error(Errc::usage, option("by") + ": '" + options.by +
                                  "' is no density; give voronoi, density, or density_NAME for the masses NAME");
  if (options.target.empty()) return success();
  return check_voids_target(options.target, options.overwrite);
}

Result<FoundVoids> find_voids(const fs::path& out, const VoidsOptions& options, std::stop_token stop) {
  BOOST_OUTCOME_TRYV(check_voids_options(options));
  BOOST_OUTCOME_TRY(measured, measure_missing(out, options, stop));
  BOOST_OUTCOME_TRY(next, NewVersion::begin(out, {.lock = options.lock, .keep = {}, .periods = Periods::known}));
  return Search(*next, options, std::move(stop)).run(measured ? columns_part : 0);
}

std::string to_json(const Found& found) {
  using Json = nlohmann::ordered_json;
  Json files = Json::array();
  for (const fs::path& file : found.files) files.push_back(file.string());
  return json_text(Json{{"event", "voids"},
                        {"output", found.folder.string()},
                        {"version", found.version},
                        {"made", found.made},
                        {"column", found.column},
                        {"zones", found.zones},
                        {"points", found.points},
                        {"outside", found.outside},
                        {"files", std::move(files)},
                        {"unit", found.unit}});
}

}  // namespace tessera::voids
