#include "src/result/terrain/contours.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "src/base/crs/crs.h"
#include "src/base/files/temporary.h"
#include "src/base/json/json_text.h"
#include "src/base/stopped.h"
#include "src/result/export/output.h"
#include "src/result/query/column.h"
#include "src/result/query/query_tile.h"
#include "src/result/store/stamp.h"
#include "src/result/store/tile_store.h"
#include "src/result/terrain/contour_cells.h"
#include "src/result/terrain/line_file.h"
#include "src/result/terrain/line_maker.h"
#include "src/result/terrain/smooth_surface.h"
#include "src/result/terrain/tiles.h"
#include "src/result/terrain/tracing.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

// The fraction of the progress for reading tiles; the rest is for writing lines.
constexpr double reading_part = 0.7;

bool is_shorter(std::span<const Point> points, double length) {
  double sum = 0;
  for (std::size_t i = 1; i < points.size() && sum < length; ++i)
    sum += std::hypot(points[i].x - points[i - 1].x, points[i].y - points[i - 1].y);
  return sum < length;
}

// Calls give(level, line) for all lines that are long enough. Returns the number of the others. Error interrupted.
template <class Give>
Result<std::uint64_t> for_each_line(terrain::Traced& traced, const ContourOptions& options, const Give& give,
                                    const std::stop_token& stop) {
  std::uint64_t shorter = 0;
  BOOST_OUTCOME_TRYV(traced.lines.for_each([&](std::int64_t level, std::span<const Point> points) -> Status {
    if (stop.stop_requested()) return error(Errc::interrupted, "interrupted while writing lines");
    if (options.min_length && is_shorter(points, *options.min_length)) {
      ++shorter;
      return success();
    }
    return give(level, ContourLine{traced.levels.height(level), level % options.index_every == 0, points});
  }));
  return shorter;
}

}  // namespace

std::optional<Bounds> source_box(const ContourOptions& options) {
  if (!options.box || !options.smooth) return options.box;
  return terrain::around(*options.box, *options.smooth);
}

std::string to_json(const Contours& contours) {
  using Json = nlohmann::ordered_json;
  const Json object{{"event", "contours"},           {"output", contours.path.string()}, {"lines", contours.lines},
                    {"closed", contours.closed},     {"vertices", contours.vertices},    {"levels", contours.levels},
                    {"left_out", contours.left_out}, {"shorter", contours.shorter},      {"bytes", contours.bytes},
                    {"note", contours.note}};
  return json_text(object);
}

Result<ContourCost> estimate_contours(const fs::path& out, const ContourOptions& options, std::uint64_t cells_max,
                                      const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(source, TileSource::open(out));
  const Manifest& manifest = source.manifest();
  BOOST_OUTCOME_TRYV(terrain::check_contours(out, manifest, options));
  BOOST_OUTCOME_TRY(column, query::find_column(out, manifest, options.value));
  BOOST_OUTCOME_TRYV(terrain::check_meets(manifest, options.box));
  const terrain::Levels levels(options.interval, options.base);
  std::uint64_t seen = 0, pieces = 0, all = 0;
  for (const auto& entry : manifest.tiles) all += entry.cells;
  try {
    for (std::size_t i = 0; i < source.tiles(); ++i) {
      const TileEntry& entry = source.entry(i);
      if (seen >= cells_max) break;
      if (source.work_bytes(i) > options.memory_bytes / 8) continue;
      BOOST_OUTCOME_TRY(tile, query::QueryTile::load(source, i, true));
      const terrain::ContourCells cells(*tile, column, levels,
                                        exports::CellFilter({options.max_edge, options.max_radius}), options.box, stop);
      BOOST_OUTCOME_TRYV(terrain::LineMaker::check_levels(cells));
      pieces += cells.pieces();
      seen += entry.cells;
    }
  } catch (const Stopped&) {
    return error(Errc::interrupted, "interrupted while looking at cells");
  }
  // A point of a line takes up to 55 digits and signs in a text file, and 24 bytes in a GeoPackage. Scratch has each
  // point twice: in the line of a tile, and in the whole line.
  constexpr double file_bytes = 50, scratch_bytes = 2.0 * sizeof(terrain::LinePoint);
  double points = seen == 0 ? 0 : static_cast<double>(pieces) * static_cast<double>(all) / static_cast<double>(seen);
  std::uint64_t samples_bytes = 0;
  if (options.smooth) {
    BOOST_OUTCOME_TRY(plan, terrain::plan_smooth(options, manifest.bounds));
    samples_bytes = static_cast<std::uint64_t>(plan.samples.width * plan.samples.height) * sizeof(double);
    // A line crosses about as many sides of squares as edges of the same length, and smoothing makes no line longer.
    const Bounds& all_of_it = manifest.bounds;
    const double spacing = std::sqrt((all_of_it.hi.x - all_of_it.lo.x) * (all_of_it.hi.y - all_of_it.lo.y) /
                                     static_cast<double>(manifest.vertices));
    points *= std::min(1.0, spacing / *options.smooth);
  }
  const auto whole = [](double bytes) { return static_cast<std::uint64_t>(std::min(bytes, 1e18)); };
  return ContourCost{whole(points), whole(points * file_bytes), whole(points * scratch_bytes) + samples_bytes};
}

Result<Contours> write_contours(const fs::path& out, const fs::path& target, const ContourOptions& options,
                                std::stop_token stop) {
  BOOST_OUTCOME_TRYV(terrain::LineFile::check_target(target, options.overwrite));
  const bool heights = options.value == "z";
  const auto tell = [&](double done) {
    if (options.progress) options.progress(done);
  };
  BOOST_OUTCOME_TRY(
      traced, terrain::trace(
                  out, exports::folder_of(target), options, [&](double done) { tell(reading_part * done); }, stop));

  BOOST_OUTCOME_TRY(file, terrain::LineFile::create(target, {.crs = crs_or_none(traced.manifest.crs),
                                                             .layer = "contours",
                                                             .value = heights ? "elevation" : options.value,
                                                             .stamp = stamp_of(traced.manifest),
                                                             .heights = heights}));
  Contours contours{
      .path = target, .left_out = traced.left_out, .note = terrain::note_of(traced.manifest, source_box(options))};
  std::optional<std::int64_t> last;
  const auto write = [&](std::int64_t level, const ContourLine& line) -> Status {
    ++contours.lines;
    contours.closed += line.points.front() == line.points.back() ? 1 : 0;
    contours.vertices += line.points.size();
    contours.levels += last != level ? 1 : 0;
    last = level;
    return file->add(line.value, line.index, line.points);
  };
  BOOST_OUTCOME_TRY(shorter, for_each_line(traced, options, write, stop));
  contours.shorter = shorter;
  BOOST_OUTCOME_TRY(bytes, file->finish());
  contours.bytes = bytes;
  tell(1);
  return contours;
}

Status trace_contours(const fs::path& out, const ContourOptions& options,
                      const std::function<void(const ContourLine&)>& take, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(folder, folder_for_temporary());
  BOOST_OUTCOME_TRY(traced, terrain::trace(
                                out, folder, options, [](double) {}, stop));
  const auto give = [&](std::int64_t, const ContourLine& line) -> Status {
    take(line);
    return success();
  };
  BOOST_OUTCOME_TRY(shorter, for_each_line(traced, options, give, stop));
  static_cast<void>(shorter);
  return success();
}

}  // namespace tessera
