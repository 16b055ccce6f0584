#include "src/result/voronoi/voronoi.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <nlohmann/json.hpp>
#include <numeric>
#include <utility>
#include <vector>

#include "src/base/crs/crs.h"
#include "src/base/json/json_text.h"
#include "src/base/on_threads.h"
#include "src/base/option.h"
#include "src/result/export/ending.h"
#include "src/result/export/output.h"
#include "src/result/store/stamp.h"
#include "src/result/tile_queue.h"
#include "src/result/voronoi/cell_file.h"
#include "src/result/voronoi/planar_cells.h"
#include "src/result/voronoi/read_clip.h"
#include "src/result/voronoi/repairs.h"
#include "src/result/voronoi/space_cells.h"
#include "src/result/voronoi/vtu_cells.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

using voronoi::CellCounts;
using voronoi::CellRecord;
using voronoi::CellRecords;
using voronoi::ClipRegion;

// The fraction of the progress for making cells; the rest is for writing them.
constexpr double making_part = 0.4;

Result<std::optional<ClipRegion>> region_of(const TileSource& source, const VoronoiOptions& options,
                                            const std::stop_token& stop) {
  const auto some = [](Result<ClipRegion> region) -> Result<std::optional<ClipRegion>> {
    if (!region) return region.error();
    return std::optional(std::move(region).value());
  };
  switch (options.clip) {
    case VoronoiClip::none:
      return std::optional<ClipRegion>();
    case VoronoiClip::box:
      return some(voronoi::box_region(options.box));
    case VoronoiClip::file:
      if (!voronoi::is_region_file(options.polygons))
        return error(Errc::usage, option("clip") + ": '" + options.polygons.string() +
                                      "' is neither hull, none, a box nor a file that ends in .gpkg, .fgb, .shp or "
                                      ".geojson");
      return some(voronoi::file_region(options.polygons, source.manifest()));
    case VoronoiClip::automatic:
    case VoronoiClip::hull:
      break;
  }
  return some(voronoi::hull_region(source, stop));
}

// Makes the records of all tiles, on threads. `work` adds those of one tile.
template <class Work>
Result<CellCounts> make_records(const TileSource& source, const VoronoiOptions& options, CellRecords& records,
                                const std::stop_token& stop, const Work& work) {
  std::vector<std::size_t> all(source.tiles());
  std::iota(all.begin(), all.end(), std::size_t{0});
  TileQueue tiles(source, std::move(all), stop, [&](double done) {
    if (options.progress) options.progress(making_part * done);
  });
  constexpr double tile_factor = 3;  // a tile as a mesh, the cells around its vertices, and circumcentres
  std::mutex mutex;
  CellCounts counts;
  std::atomic<bool> failed{false};
  BOOST_OUTCOME_TRYV(
      on_threads(tiles.threads(options.threads, options.memory_bytes / 4 * 3, tile_factor, 0), failed, [&]() -> Status {
        CellRecords::Adder adder(records);
        CellCounts own;
        while (!failed) {
          BOOST_OUTCOME_TRY(index, tiles.next());
          if (!index) break;
          BOOST_OUTCOME_TRY(of_tile, work(tiles.source(), *index, adder));
          own.add(of_tile);
          tiles.done();
        }
        BOOST_OUTCOME_TRYV(adder.flush());
        const std::lock_guard lock(mutex);
        counts.add(own);
        return success();
      }));
  return counts;
}

// The box of a 3D result, if there is one.
Result<std::optional<Bounds>> space_box(const VoronoiOptions& options) {
  if (options.clip != VoronoiClip::box) return std::optional<Bounds>();
  for (int axis = 0; axis < 3; ++axis) {
    const double lo = options.box.lo[axis], hi = options.box.hi[axis];
    if (!std::isfinite(lo) || !std::isfinite(hi) || !(lo < hi))
      return error(Errc::usage,
                   option("clip") +
                       ": is no box of a 3D result; give xmin,ymin,zmin,xmax,ymax,zmax, each minimum below "
                       "its maximum");
  }
  return std::optional(options.box);
}

Result<CellCounts> make_planar(const TileSource& source, const VoronoiOptions& options, CellRecords& records,
                               voronoi::Repairs& repairs, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(region, region_of(source.stopped_by(stop), options, stop));
  return make_records(source, options, records, stop,
                      [&](const TileSource& from, std::size_t index, CellRecords::Adder& to) {
                        return voronoi::add_planar_cells(from, index, region ? &*region : nullptr,
                                                         options.clip == VoronoiClip::file, repairs, to, stop);
                      });
}

Result<CellCounts> make_spatial(const TileSource& source, const VoronoiOptions& options, CellRecords& records,
                                const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(box, space_box(options));
  return make_records(source, options, records, stop,
                      [&](const TileSource& from, std::size_t index, CellRecords::Adder& to) {
                        return voronoi::add_space_cells(from, index, box, to, stop);
                      });
}

Status check_result(const fs::path& out, const Manifest& manifest, const VoronoiOptions& options) {
  if (manifest.region)
    return error(Errc::usage, out.string() +
                                  ": is a region, where not all cells around a vertex are known; Voronoi cells "
                                  "need a whole triangulation");
  if (manifest.dimension == 3 && (options.clip == VoronoiClip::hull || options.clip == VoronoiClip::file))
    return error(Errc::usage, out.string() + ": is a 3D result, whose cells are clipped to a box alone; give " +
                                  option("clip") + " six numbers, or leave it out");
  return success();
}

// The clip of a periodic result: none.
Result<VoronoiOptions> suited_to(const TileSource& source, const VoronoiOptions& options) {
  VoronoiOptions suited = options;
  if (!source.period().any()) return suited;
  if (options.clip != VoronoiClip::automatic && options.clip != VoronoiClip::none)
    return error(Errc::usage, source.folder().string() +
                                  ": holds the triangulation of a periodic cloud, whose Voronoi cells are written "
                                  "whole, each once; leave " +
                                  option("clip") + " out");
  suited.clip = VoronoiClip::none;
  return suited;
}

// Applies the repairs to a cell, and measures it again. `wkb` keeps its new shape.
void repair(CellRecord& record, const voronoi::Repairs& repairs, bool multi, std::vector<std::byte>& wkb,
            WrittenVoronoi& written) {
  voronoi::CellShape shape = voronoi::shape_of_wkb(record.shape);
  if (!repairs.apply(shape)) return;
  bool thin = std::erase_if(shape.parts, [](const auto& part) { return !voronoi::is_valid(part); }) > 0;
  const auto area = [](const auto& part) { return voronoi::measure({{part}}).area; };
  if (!multi && shape.parts.size() > 1) {  // the file has polygons of one part
    thin = true;
    const auto most = std::max_element(shape.parts.begin(), shape.parts.end(),
                                       [&](const auto& a, const auto& b) { return area(a) < area(b); });
    shape.parts = {*most};
  }
  std::sort(shape.parts.begin(), shape.parts.end(), voronoi::part_before);
  written.thin += thin || shape.parts.empty() ? 1 : 0;
  written.shapeless += shape.parts.empty() ? 1 : 0;
  const voronoi::ShapeMeasures measures =
      shape.parts.empty() ? voronoi::ShapeMeasures{.area = 0, .centroid = {std::nan(""), std::nan(""), 0}}
                          : voronoi::measure(shape);
  record.head.size = measures.area;
  record.head.centroid[0] = measures.centroid.x;
  record.head.centroid[1] = measures.centroid.y;
  wkb = voronoi::to_wkb(shape, multi);
  record.shape = wkb;
}

// Writes all records by id. Returns the size of the file.
Result<std::uint64_t> write_records(CellRecords& records, const voronoi::Repairs& repairs, voronoi::CellFile& file,
                                    const VoronoiOptions& options, WrittenVoronoi& written,
                                    const std::stop_token& stop) {
  long double sum = 0;
  std::vector<std::byte> wkb;
  BOOST_OUTCOME_TRYV(records.for_each([&](const CellRecord& made) -> Status {
    CellRecord record = made;
    if (!repairs.empty()) repair(record, repairs, options.clip == VoronoiClip::file, wkb, written);
    if (written.cells % 4096 == 0) {
      if (stop.stop_requested()) return error(Errc::interrupted, "interrupted while writing cells");
      const double done = static_cast<double>(written.cells) / static_cast<double>(records.count());
      if (options.progress) options.progress(making_part + (1 - making_part) * done);
    }
    ++written.cells;
    if (std::isfinite(record.head.size)) sum += record.head.size;
    return file.add(record);
  }));
  written.size = static_cast<double>(sum);
  return file.finish();
}

}  // namespace

Result<WrittenVoronoi> write_voronoi(const fs::path& out, const fs::path& target, const VoronoiOptions& asked,
                                     std::stop_token stop) {
  BOOST_OUTCOME_TRYV(exports::check_free(target, asked.overwrite));
  BOOST_OUTCOME_TRY(source, TileSource::open(out, Periods::known));
  BOOST_OUTCOME_TRY(options, suited_to(source, asked));
  const Manifest& manifest = source.manifest();
  BOOST_OUTCOME_TRYV(check_result(out, manifest, options));
  const bool flat = manifest.dimension == 2;
  BOOST_OUTCOME_TRYV(flat ? voronoi::CellFile::check_ending(target) : voronoi::check_vtu_ending(target));
  BOOST_OUTCOME_TRY(records, CellRecords::create(exports::folder_of(target), row_bytes(manifest.schema),
                                                 options.memory_bytes / 4, stop));
  voronoi::Repairs repairs;
  BOOST_OUTCOME_TRY(counts, flat ? make_planar(source, options, *records, repairs, stop)
                                 : make_spatial(source, options, *records, stop));
  if (records->count() == 0)
    return error(Errc::usage, options.clip == VoronoiClip::box || options.clip == VoronoiClip::file
                                  ? option("clip") + ": no cell of the result meets it"
                                  : out.string() + ": has no bounded cell; give " + option("clip") + " a box");
  BOOST_OUTCOME_TRY(file, flat ? voronoi::CellFile::create(target, {.crs = crs_or_none(manifest.crs),
                                                                    .stamp = stamp_of(manifest),
                                                                    .multi = options.clip == VoronoiClip::file,
                                                                    .schema = manifest.schema})
                               : voronoi::create_vtu_cells(target, {.stamp = stamp_of(manifest),
                                                                    .schema = manifest.schema,
                                                                    .memory_bytes = options.memory_bytes / 2,
                                                                    .stop = stop}));
  WrittenVoronoi written{.path = target,
                         .dimension = manifest.dimension,
                         .unbounded = counts.unbounded,
                         .outside = counts.outside,
                         .shapeless = counts.shapeless,
                         .thin = counts.thin,
                         .duplicates = manifest.duplicates,
                         .note = flat ? crs_note(manifest.crs) : std::string()};
  repairs.finish();
  BOOST_OUTCOME_TRY(bytes, write_records(*records, repairs, *file, options, written, stop));
  written.bytes = bytes;
  if (options.progress) options.progress(1);
  return written;
}

std::string to_json(const WrittenVoronoi& written) {
  using Json = nlohmann::ordered_json;
  const Json object{{"event", "voronoi"},
                    {"output", written.path.string()},
                    {"dimension", written.dimension},
                    {"cells", written.cells},
                    {"unbounded", written.unbounded},
                    {"outside", written.outside},
                    {"shapeless", written.shapeless},
                    {"thin", written.thin},
                    {"duplicates", written.duplicates},
                    {written.dimension == 2 ? "area" : "volume", written.size},
                    {"bytes", written.bytes},
                    {"note", written.note}};
  return json_text(object);
}

}  // namespace tessera
