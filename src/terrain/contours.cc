#include "src/terrain/contours.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>
#include <vector>

#include "src/base/option.h"
#include "src/base/stopped.h"
#include "src/crs/crs.h"
#include "src/export/output.h"
#include "src/files/names.h"
#include "src/query/column.h"
#include "src/query/on_threads.h"
#include "src/query/query_tile.h"
#include "src/store/tile_store.h"
#include "src/terrain/contour_cells.h"
#include "src/terrain/contour_lines.h"
#include "src/terrain/line_file.h"
#include "src/terrain/link_pieces.h"
#include "src/terrain/tiles.h"

namespace tessera {

namespace fs = std::filesystem;

namespace terrain {
namespace {

// Of the whole, reading tiles; the rest is writing lines.
constexpr double reading_part = 0.7;
constexpr std::uint64_t ends_bytes_min = std::uint64_t{8} << 20;
// A piece, and the point of a line that it makes.
constexpr std::uint64_t piece_bytes = sizeof(Piece) + 2 * sizeof(std::size_t) + sizeof(LinePoint);
// At once: so many are sorted in some tenths of a second, between two looks at whether to stop.
constexpr std::uint64_t pieces_at_once = 1 << 21;
// As a mesh with attributes and neighbours, its values, and what reading takes beside it.
constexpr double tile_factor = 1.5;

// Also a tile whose levels could not be counted in memory has an interval that is none.
Status check_levels(const ContourCells& cells) {
  constexpr std::int64_t levels_max = 1 << 22;
  if (cells.too_far() || cells.end() - cells.begin() > levels_max)
    return error(Errc::usage, option("interval") + ": is too small for the values of the vertices");
  return success();
}

class Tracing {
 public:
  Tracing(const fs::path& out, const Manifest& manifest, const query::Column& column, const ContourOptions& options,
          ContourLines& lines, std::stop_token stop)
      : out_(out),
        manifest_(manifest),
        column_(column),
        levels_(options.interval, options.base),
        options_(options),
        lines_(lines),
        stop_(std::move(stop)) {}

  Status run(TileQueue& tiles, std::uint64_t memory_bytes) {
    constexpr std::uint64_t pieces_least = 1 << 16;
    const unsigned threads = tiles.threads(options_.threads, memory_bytes, tile_factor, pieces_least * piece_bytes);
    const std::uint64_t share = memory_bytes / threads, tile_bytes = tiles.tile_bytes(tile_factor);
    pieces_max_ = std::clamp((share - std::min(share, tile_bytes)) / piece_bytes, pieces_least, pieces_at_once);
    std::atomic<bool> failed{false};
    return query::on_threads(threads, failed, [&]() -> Status {
      while (!failed) {
        BOOST_OUTCOME_TRY(entry, tiles.next());
        if (entry == nullptr) break;
        BOOST_OUTCOME_TRYV(trace(*entry));
        tiles.done();
      }
      return success();
    });
  }
  std::uint64_t left_out() const { return left_out_; }
  const Levels& levels() const { return levels_; }

 private:
  Status trace(const TileEntry& entry) {
    BOOST_OUTCOME_TRY(tile, query::QueryTile::load(out_, manifest_, entry, true));
    const ContourCells cells(*tile, column_, levels_, options_.max_edge, options_.box, stop_);
    BOOST_OUTCOME_TRYV(check_levels(cells));
    left_out_ += cells.left_out();
    const std::vector<std::uint64_t> most = cells.most_pieces();
    std::vector<Piece> pieces;
    std::vector<LinePoint> points;
    // So many levels at once as there is room for.
    for (std::int64_t begin = cells.begin(), end = begin; begin < cells.end(); begin = end) {
      std::uint64_t count = 0;
      do count += most[static_cast<std::size_t>(end++ - cells.begin())];
      while (end < cells.end() && count + most[static_cast<std::size_t>(end - cells.begin())] <= pieces_max_);
      pieces.clear();
      BOOST_OUTCOME_TRYV(cells.for_each_piece(
          begin, end, [&](const Piece& piece) { pieces.push_back(piece); }, stop_));
      BOOST_OUTCOME_TRYV(link_pieces(pieces, [&](std::int64_t level, const std::vector<TileEdge>& edges) -> Status {
        throw_if_stopped(stop_);
        points.clear();
        for (const TileEdge& edge : edges) {
          const Point at = cells.crossing(edge, level);
          points.push_back({tile->id_of(edge.a), tile->id_of(edge.b), at.x, at.y});
        }
        vertices_ += points.size();
        if (options_.vertices_max > 0 && vertices_ > options_.vertices_max)
          return error(Errc::memory, "the lines have more than " + std::to_string(options_.vertices_max) +
                                         " vertices: ask for a smaller " + option("bbox") + " or a larger " +
                                         option("interval"));
        return lines_.add(level, points);
      }));
    }
    return success();
  }

  const fs::path& out_;
  const Manifest& manifest_;
  query::Column column_;
  Levels levels_;
  const ContourOptions& options_;
  ContourLines& lines_;
  std::stop_token stop_;
  std::uint64_t pieces_max_ = 0;
  std::atomic<std::uint64_t> left_out_{0}, vertices_{0};
};

Status check(const fs::path& out, const Manifest& manifest, const ContourOptions& options) {
  if (!(std::isfinite(options.interval) && options.interval > 0))
    return error(Errc::usage, option("interval") + ": must be a length, finite and above 0");
  if (!std::isfinite(options.base)) return error(Errc::usage, option("base") + ": must be finite");
  if (options.max_edge && !(std::isfinite(*options.max_edge) && *options.max_edge > 0))
    return error(Errc::usage, option("max-edge") + ": must be a length, finite and above 0");
  if (manifest.dimension != 2)
    return error(Errc::usage, out.string() + ": is a 3D result, which has no heights over a plane; triangulate with " +
                                  option("dim", "2"));
  return success();
}

// Lines that were traced, and what they are of.
struct Traced {
  Manifest manifest;
  ContourLines lines;
  Levels levels;
  std::uint64_t left_out = 0;
};

// `folder`: where lines wait.
Result<Traced> trace(const fs::path& out, const fs::path& folder, const ContourOptions& options,
                     const std::function<void(double)>& progress, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(manifest, read_manifest(out));
  BOOST_OUTCOME_TRYV(check(out, manifest, options));
  BOOST_OUTCOME_TRY(column, query::find_column(out, manifest, options.value));
  BOOST_OUTCOME_TRYV(check_meets(manifest, options.box));

  // A quarter for sorting, a quarter for what ends at borders, the rest for tiles. What ends at borders has no other
  // place, so that a few megabytes are its own however little there is.
  const std::uint64_t quarter = options.memory_bytes / 4, tile_bytes = options.memory_bytes - 2 * quarter;
  BOOST_OUTCOME_TRY(entries, tiles_meeting(out, manifest, options.box, {.memory_bytes = tile_bytes, .stop = stop}));
  TileQueue tiles(std::move(entries), stop, progress);
  BOOST_OUTCOME_TRY(lines, ContourLines::create(folder, {quarter, std::max(quarter, ends_bytes_min)}, stop));
  Tracing tracing(out, manifest, column, options, lines, stop);
  BOOST_OUTCOME_TRYV(tracing.run(tiles, tile_bytes));
  const Levels levels = tracing.levels();
  const std::uint64_t left_out = tracing.left_out();
  return Traced{std::move(manifest), std::move(lines), levels, left_out};
}

}  // namespace
}  // namespace terrain

std::string to_json(const Contours& contours) {
  using Json = nlohmann::ordered_json;
  const Json object{{"event", "contours"},           {"output", contours.path.string()}, {"lines", contours.lines},
                    {"closed", contours.closed},     {"vertices", contours.vertices},    {"levels", contours.levels},
                    {"left_out", contours.left_out}, {"bytes", contours.bytes},          {"note", contours.note}};
  return object.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Result<ContourCost> estimate_contours(const fs::path& out, const ContourOptions& options, std::uint64_t cells_max,
                                      const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(manifest, read_manifest(out));
  BOOST_OUTCOME_TRYV(terrain::check(out, manifest, options));
  BOOST_OUTCOME_TRY(column, query::find_column(out, manifest, options.value));
  BOOST_OUTCOME_TRYV(terrain::check_meets(manifest, options.box));
  const terrain::Levels levels(options.interval, options.base);
  std::uint64_t seen = 0, pieces = 0, all = 0;
  for (const auto& entry : manifest.tiles) all += entry.cells;
  try {
    for (const auto& entry : manifest.tiles) {
      if (seen >= cells_max) break;
      if (entry.bytes > options.memory_bytes / 8) continue;
      BOOST_OUTCOME_TRY(tile, query::QueryTile::load(out, manifest, entry, true));
      const terrain::ContourCells cells(*tile, column, levels, options.max_edge, options.box, stop);
      BOOST_OUTCOME_TRYV(terrain::check_levels(cells));
      pieces += cells.pieces();
      seen += entry.cells;
    }
  } catch (const Stopped&) {
    return error(Errc::interrupted, "interrupted while looking at cells");
  }
  // A point of a line in a file of text has up to 55 digits and signs, in a GeoPackage 24 bytes. In scratch it is
  // twice: as a tile has it, and in the whole line.
  constexpr double file_bytes = 50, scratch_bytes = 2.0 * sizeof(terrain::LinePoint);
  const double points =
      seen == 0 ? 0 : static_cast<double>(pieces) * static_cast<double>(all) / static_cast<double>(seen);
  const auto whole = [](double bytes) { return static_cast<std::uint64_t>(std::min(bytes, 1e18)); };
  return ContourCost{whole(points), whole(points * file_bytes), whole(points * scratch_bytes)};
}

Result<Contours> write_contours(const fs::path& out, const fs::path& target, const ContourOptions& options,
                                std::stop_token stop) {
  BOOST_OUTCOME_TRYV(terrain::LineFile::check_target(target, options.overwrite));
  const bool heights = options.value == "z";
  const auto tell = [&](double done) {
    if (options.progress) options.progress(done);
  };
  BOOST_OUTCOME_TRY(traced, terrain::trace(
                                out, exports::folder_of(target), options,
                                [&](double done) { tell(terrain::reading_part * done); }, stop));

  BOOST_OUTCOME_TRY(file, terrain::LineFile::create(target, {.crs = crs_or_none(traced.manifest.crs),
                                                             .layer = "contours",
                                                             .value = heights ? "elevation" : options.value,
                                                             .heights = heights}));
  Contours contours{
      .path = target, .left_out = traced.left_out, .note = terrain::note_of(traced.manifest, options.box)};
  std::optional<std::int64_t> last;
  BOOST_OUTCOME_TRYV(traced.lines.for_each([&](std::int64_t level, std::span<const Point> points) -> Status {
    if (stop.stop_requested()) return error(Errc::interrupted, "interrupted while writing lines");
    ++contours.lines;
    contours.closed += points.front() == points.back() ? 1 : 0;
    contours.vertices += points.size();
    contours.levels += last != level ? 1 : 0;
    last = level;
    return file->add(traced.levels.height(level), points);
  }));
  BOOST_OUTCOME_TRY(bytes, file->finish());
  contours.bytes = bytes;
  tell(1);
  return contours;
}

Status trace_contours(const fs::path& out, const ContourOptions& options,
                      const std::function<void(double, std::span<const Point>)>& take, const std::stop_token& stop) {
  std::error_code failed;
  const fs::path folder = fs::temp_directory_path(failed);
  if (failed) return error(Errc::io, "the system's temporary folder: " + failed.message());
  BOOST_OUTCOME_TRY(traced, terrain::trace(
                                out, folder, options, [](double) {}, stop));
  return traced.lines.for_each([&](std::int64_t level, std::span<const Point> points) -> Status {
    if (stop.stop_requested()) return error(Errc::interrupted, "interrupted while reading lines");
    take(traced.levels.height(level), points);
    return success();
  });
}

}  // namespace tessera
