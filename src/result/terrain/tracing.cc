#include "src/result/terrain/tracing.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "src/base/on_threads.h"
#include "src/base/option.h"
#include "src/result/query/column.h"
#include "src/result/query/query_tile.h"
#include "src/result/terrain/contour_cells.h"
#include "src/result/terrain/drawing.h"
#include "src/result/terrain/line_maker.h"
#include "src/result/terrain/smooth_surface.h"
#include "src/result/terrain/tiles.h"

namespace tessera::terrain {

namespace fs = std::filesystem;

namespace {

constexpr std::uint64_t ends_bytes_min = std::uint64_t{8} << 20;

// What both ways of tracing need.
struct Work {
  const TileSource& source;
  const query::Column& column;
  const ContourOptions& options;
  const Levels& levels;
  LineMaker& maker;
  std::uint64_t memory_bytes;  // for tiles, samples and pieces
  const std::function<void(double)>& progress;
  std::stop_token stop;
};

// Returns the number of cells left out because of their edges.
Result<std::uint64_t> trace_tiles(const Work& work) {
  // A tile is a mesh with attributes, neighbours and values, and reading needs some more.
  constexpr double tile_factor = 1.5;
  BOOST_OUTCOME_TRY(
      entries, tiles_meeting(work.source, work.options.box, {.memory_bytes = work.memory_bytes, .stop = work.stop}));
  TileQueue tiles(work.source, std::move(entries), work.stop, work.progress);
  const unsigned threads = tiles.threads(work.options.threads, work.memory_bytes, tile_factor,
                                         LineMaker::pieces_least * LineMaker::piece_bytes);
  const std::uint64_t share = work.memory_bytes / threads, tile_bytes = tiles.tile_bytes(tile_factor);
  std::atomic<std::uint64_t> left_out{0};
  std::atomic<bool> failed{false};
  BOOST_OUTCOME_TRYV(on_threads(threads, failed, [&]() -> Status {
    while (!failed) {
      BOOST_OUTCOME_TRY(index, tiles.next());
      if (!index) break;
      BOOST_OUTCOME_TRY(tile, query::QueryTile::load(tiles.source(), *index, true));
      const ContourCells cells(*tile, work.column, work.levels,
                               exports::CellFilter({work.options.max_edge, work.options.max_radius}), work.options.box,
                               work.stop);
      BOOST_OUTCOME_TRYV(work.maker.add(cells, share - std::min(share, tile_bytes)));
      left_out += cells.left_out();
      tiles.done();
    }
    return success();
  }));
  return left_out.load();
}

// Draws the samples of the surface into `samples`. Returns the number of cells left out because of their edges.
Result<std::uint64_t> draw_samples(const Work& work, const SmoothPlan& plan, const SampleFile& samples,
                                   std::function<void(double)> progress) {
  const auto box = work.options.box ? std::optional(plan.around) : std::nullopt;
  BOOST_OUTCOME_TRY(entries, tiles_meeting(work.source, box, {.memory_bytes = work.memory_bytes, .stop = work.stop}));
  TileQueue tiles(work.source, std::move(entries), work.stop, std::move(progress));
  Drawing drawing(work.source.folder(), work.source.manifest(), work.column, plan.samples,
                  {.max_edge = work.options.max_edge,
                   .max_radius = work.options.max_radius,
                   .doubles = true,
                   .memory_bytes = work.memory_bytes,
                   .threads = work.options.threads},
                  work.stop, [&](Blocks& blocks) { return samples.add(blocks); });
  BOOST_OUTCOME_TRYV(drawing.run(tiles));
  return drawing.left_out();
}

Result<std::uint64_t> trace_smooth(const Work& work, const SmoothPlan& plan, const fs::path& folder) {
  constexpr double drawing_part = 0.7;
  BOOST_OUTCOME_TRY(samples, SampleFile::create(folder, plan.samples));
  BOOST_OUTCOME_TRY(left_out,
                    draw_samples(work, plan, samples, [&](double done) { work.progress(drawing_part * done); }));
  const std::vector<Lattice> parts = parts_of(plan.nodes);
  // A part has its nodes, and 16 samples for each node.
  constexpr std::uint64_t part_bytes = (part_squares + 2) * (part_squares + 2) * 17 * sizeof(double);
  const unsigned threads = static_cast<unsigned>(std::clamp<std::uint64_t>(
      std::min<std::uint64_t>(work.memory_bytes / (part_bytes + LineMaker::pieces_least * LineMaker::piece_bytes),
                              parts.size()),
      1, std::max(work.options.threads, 1U)));
  const std::uint64_t share = work.memory_bytes / threads;
  std::atomic<std::size_t> next{0}, done{0};
  std::mutex telling;
  std::atomic<bool> failed{false};
  BOOST_OUTCOME_TRYV(on_threads(threads, failed, [&]() -> Status {
    SmoothSurface surface(samples, work.levels);
    for (std::size_t i = next++; i < parts.size() && !failed; i = next++) {
      if (work.stop.stop_requested()) return error(Errc::interrupted, "interrupted while tracing lines");
      std::vector<double> values;
      BOOST_OUTCOME_TRYV(surface.read(parts[i], values));
      const SquareCells cells(parts[i], plan.whole, std::move(values));
      BOOST_OUTCOME_TRYV(work.maker.add(cells, share - std::min(share, part_bytes)));
      const std::lock_guard lock(telling);
      work.progress(drawing_part +
                    (1 - drawing_part) * static_cast<double>(++done) / static_cast<double>(parts.size()));
    }
    return success();
  }));
  return left_out;
}

}  // namespace

Status check_contours(const fs::path& out, const Manifest& manifest, const ContourOptions& options) {
  if (!(std::isfinite(options.interval) && options.interval > 0))
    return error(Errc::usage, option("interval") + ": must be a length, finite and above 0");
  if (!std::isfinite(options.base)) return error(Errc::usage, option("base") + ": must be finite");
  if (options.min_length && !(std::isfinite(*options.min_length) && *options.min_length > 0))
    return error(Errc::usage, option("min-length") + ": must be a length, finite and above 0");
  if (options.index_every < 1 || options.index_every > index_every_max)
    return error(Errc::usage, option("index-every") + ": must be from 1 to " + std::to_string(index_every_max));
  return check_surface(out, manifest, {options.max_edge, options.max_radius});
}

Result<Traced> trace(const fs::path& out, const fs::path& folder, const ContourOptions& options,
                     const std::function<void(double)>& progress, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(source, TileSource::open(out));
  const Manifest& manifest = source.manifest();
  BOOST_OUTCOME_TRYV(check_contours(out, manifest, options));
  BOOST_OUTCOME_TRY(column, query::find_column(out, manifest, options.value));
  BOOST_OUTCOME_TRYV(check_meets(manifest, options.box));

  // A quarter of the memory is for sorting, a quarter for lines that end at borders, the rest for tiles. Lines that end
  // at borders cannot go to disk, so they get a few megabytes in any case.
  const std::uint64_t quarter = options.memory_bytes / 4;
  BOOST_OUTCOME_TRY(lines, ContourLines::create(folder, {quarter, std::max(quarter, ends_bytes_min)}, stop));
  const Levels levels(options.interval, options.base);
  LineMaker maker(lines, options.vertices_max, stop);
  const Work work{source, column, options, levels, maker, options.memory_bytes - 2 * quarter, progress, stop};
  std::uint64_t left_out = 0;
  if (options.smooth) {
    BOOST_OUTCOME_TRY(plan, plan_smooth(options, manifest.bounds));
    BOOST_OUTCOME_TRY(cells, trace_smooth(work, plan, folder));
    left_out = cells;
  } else {
    BOOST_OUTCOME_TRY(cells, trace_tiles(work));
    left_out = cells;
  }
  return Traced{manifest, std::move(lines), levels, left_out};
}

}  // namespace tessera::terrain
