#include "src/result/volume/volumes.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

#include "src/base/crs/crs.h"
#include "src/base/crs/survey_system.h"
#include "src/base/on_threads.h"
#include "src/base/option.h"
#include "src/result/terrain/tiles.h"
#include "src/result/tile_queue.h"
#include "src/result/volume/overlay.h"
#include "src/result/volume/polygon_index.h"
#include "src/result/volume/polygons.h"
#include "src/result/volume/row_sums.h"
#include "src/result/volume/surface.h"

namespace tessera {

namespace fs = std::filesystem;

Status check_volume_options(bool second, const VolumeOptions& options) {
  const int lower = (second ? 1 : 0) + (options.plane ? 1 : 0) + (options.base.empty() ? 0 : 1);
  if (lower != 1)
    return error(Errc::usage,
                 "give one thing to compare with: a second surface, " + option("plane") + " or " + option("base"));
  if (options.plane && !std::isfinite(*options.plane))
    return error(Errc::usage, option("plane") + ": must be a finite height");
  if (!options.base.empty() && !options.within.empty())
    return error(Errc::usage, option("within") + " cannot be given with " + option("base") +
                                  ": the polygons of the base limit the volumes already");
  if (!options.name.empty() && options.base.empty() && options.within.empty())
    return error(Errc::usage, option("name") + " names polygons, so it has no effect without " + option("within") +
                                  " or " + option("base"));
  return success();
}

Status check_same_system(const fs::path& a, const std::string& crs_of_a, const fs::path& b,
                         const std::string& crs_of_b) {
  if (!surely_other_crs(crs_of_a, crs_of_b)) return success();
  return error(Errc::bad_input, b.string() + ": its coordinates are those of " + crs_title(crs_of_b) +
                                    ", and those of " + a.string() + " are of " + crs_title(crs_of_a) +
                                    "; volumes need one coordinate system");
}

namespace volume {
namespace {

constexpr std::size_t cells_a_look = 256;  // between two checks for a stop
constexpr double negligible = 1e-12;       // of an area: what the sums of its pieces may miss

// The sums of the rows that a tile adds to.
using SumsOfRows = std::map<std::uint32_t, RowSums>;

// What is asked, checked and read.
struct Asked {
  Surface a;
  std::optional<Surface> b;
  bool base = false;  // B is the polygons
  MapPolygons polygons;
};

// Adds up the pieces of all tiles.
class Computation {
 public:
  Computation(const Asked& asked, const VolumeOptions& options, std::stop_token stop)
      : asked_(asked), options_(options), stop_(std::move(stop)), index_(asked.polygons) {
    const auto& polygons = asked.polygons.polygons;
    rows_.resize(std::max<std::size_t>(polygons.size(), 1));
    if (asked.b) cache_ = std::make_unique<SurfaceCache>(*asked.b, options.memory_bytes / 4);
    if (!limited()) return;
    const Bounds& bounds = asked.polygons.frame.bounds;
    box_ = FlatBox{bounds.lo.x, bounds.lo.y, bounds.hi.x, bounds.hi.y};
  }

  Status run() {
    const double surveyed = asked_.b ? 0.2 : 0;
    if (asked_.b) {
      BOOST_OUTCOME_TRYV(
          on_tiles(*asked_.b, 0, surveyed, [&](std::size_t tile, SumsOfRows& sums) { return survey(tile, sums); }));
    }
    return on_tiles(asked_.a, surveyed, 1, [&](std::size_t tile, SumsOfRows& sums) { return add(tile, sums); });
  }
  const std::vector<RowSums>& rows() const { return rows_; }
  std::uint64_t long_edges() const { return long_edges_; }
  std::uint64_t without_height() const { return without_height_; }

 private:
  bool limited() const { return !asked_.polygons.polygons.empty(); }

  // Calls work(tile, sums) for the tiles of a surface that meet the polygons.
  template <class Work>
  Status on_tiles(const Surface& surface, double from, double to, const Work& work) {
    // A tile is a mesh with attributes, its cells with their boxes, and lists of polygons.
    constexpr double tile_factor = 2.5;
    BOOST_OUTCOME_TRY(numbers, surface.tiles(box_, options_.memory_bytes / 4, stop_));
    if (numbers.empty()) return success();
    TileQueue tiles(surface.source(), std::move(numbers), stop_, [&](double done) {
      if (options_.progress) options_.progress(from + (to - from) * done);
    });
    std::atomic<bool> failed{false};
    const unsigned threads = tiles.threads(options_.threads, options_.memory_bytes / 2, tile_factor, 0);
    return on_threads(threads, failed, [&]() -> Status {
      while (!failed) {
        BOOST_OUTCOME_TRY(tile, tiles.next());
        if (!tile) break;
        SumsOfRows sums;
        BOOST_OUTCOME_TRYV(work(*tile, sums));
        const std::lock_guard lock(mutex_);
        for (const auto& [row, sum] : sums) rows_[row].add(sum);
        tiles.done();
      }
      return success();
    });
  }

  // Finds where the cells of a tile of B are, and adds their areas.
  Status survey(std::size_t index, SumsOfRows& sums) {
    BOOST_OUTCOME_TRY(tile, cache_->get(index));
    for (std::size_t i = 0; i < tile->size(); ++i) {
      BOOST_OUTCOME_TRYV(look(i));
      const Facet cell = tile->facet(i);
      if (!limited()) sums[0].area_b.add(twice_area(cell));
      for (const OverlappedFacet& one : index_.overlapped_by(cell)) {
        RowSums& row = sums[one.polygon];
        row.add_area(row.area_b, one.area);
      }
    }
    count_left_out(*tile);
    if (tile->size() == 0) return success();
    const std::lock_guard lock(mutex_);
    boxes_of_b_.emplace_back(index, tile->box());
    return success();
  }

  // Adds the pieces of a tile of A.
  Status add(std::size_t index, SumsOfRows& sums) {
    BOOST_OUTCOME_TRY(tile, asked_.a.read(index));
    count_left_out(tile);
    std::vector<std::vector<OverlappedFacet>> near(limited() ? tile.size() : 0);
    for (std::size_t i = 0; i < tile.size(); ++i) {
      BOOST_OUTCOME_TRYV(look(i));
      const Facet cell = tile.facet(i);
      if (limited()) {
        near[i] = index_.overlapped_by(cell);
        for (const OverlappedFacet& one : near[i]) {
          RowSums& row = sums[one.polygon];
          row.add_area(row.area_a, one.area);
        }
      } else {
        sums[0].area_a.add(twice_area(cell));
      }
      if (!asked_.b) add_cell(cell, limited() ? &near[i] : nullptr, sums);
    }
    if (!asked_.b || tile.size() == 0) return success();
    for (const auto& [number, box] : boxes_of_b_) {
      if (!tile.box().meets(box)) continue;
      BOOST_OUTCOME_TRYV(add_pair(tile, near, number, box, sums));
    }
    return success();
  }

  // Adds a cell of A over a plane or the base.
  void add_cell(const Facet& cell, const std::vector<OverlappedFacet>* near, SumsOfRows& sums) const {
    const double level = options_.plane.value_or(0);
    if (near == nullptr) {
      add_piece({.upper = &cell, .level = level}, sums[0]);
      return;
    }
    for (const OverlappedFacet& one : *near) {
      const Sides sides = asked_.base ? Sides{.upper = &cell, .lower = one.facet}
                                      : Sides{.upper = &cell, .level = level, .within = one.facet};
      add_piece(sides, sums[one.polygon]);
    }
  }

  // Adds the pieces of a tile of A and a tile of B.
  Status add_pair(const SurfaceTile& a, const std::vector<std::vector<OverlappedFacet>>& near, std::size_t number,
                  const FlatBox& box, SumsOfRows& sums) {
    std::shared_ptr<const SurfaceTile> b;
    for (std::size_t i = 0; i < a.size(); ++i) {
      BOOST_OUTCOME_TRYV(look(i));
      if (limited() && near[i].empty()) continue;
      const Facet upper = a.facet(i);
      if (!box_of(upper).meets(box)) continue;
      if (!b) {
        BOOST_OUTCOME_TRY(read, cache_->get(number));
        b = std::move(read);
      }
      b->tree().for_each_near(box_of(upper), [&](std::uint32_t j) {
        const Facet lower = b->facet(j);
        if (!limited()) add_piece({.upper = &upper, .lower = &lower}, sums[0]);
        for (const OverlappedFacet& one : limited() ? near[i] : none_)
          if (box_of(lower).meets(box_of(*one.facet)))
            add_piece({.upper = &upper, .lower = &lower, .within = one.facet}, sums[one.polygon]);
      });
    }
    return success();
  }

  static void add_piece(const Sides& sides, RowSums& row) {
    if (const auto piece = overlay(sides)) row.add(*piece);
  }
  Status look(std::size_t i) const {
    if (i % cells_a_look == 0 && stop_.stop_requested())
      return error(Errc::interrupted, "interrupted while computing volumes");
    return success();
  }
  void count_left_out(const SurfaceTile& tile) {
    long_edges_ += tile.long_edges();
    without_height_ += tile.without_height();
  }

  const Asked& asked_;
  const VolumeOptions& options_;
  std::stop_token stop_;
  PolygonIndex index_;
  std::optional<FlatBox> box_;  // of the polygons
  std::unique_ptr<SurfaceCache> cache_;
  const std::vector<OverlappedFacet> none_;
  std::mutex mutex_;  // for the members below
  std::vector<RowSums> rows_;
  std::vector<std::pair<std::size_t, FlatBox>> boxes_of_b_;
  std::atomic<std::uint64_t> long_edges_{0}, without_height_{0};
};

// The polygon's number and name are set already.
void fill_in(const Asked& asked, const MapPolygon* polygon, const RowSums& sums, VolumeRow& row) {
  ExactSum whole, by_a = sums.area_a, by_b = sums.area_b;
  if (polygon != nullptr) {
    for (const Facet& facet : polygon->facets) whole.add(twice_area(facet));
    if (!asked.b) by_b = whole;
  } else if (asked.b) {
    whole = minus(by_a, sums.covered);
    whole.add(by_b);
  } else {
    whole = by_b = by_a;
  }
  row.cut = rounded_quotient(sums.above.value(), 1);
  row.fill = rounded_quotient(sums.below.value(), 1);
  row.net = rounded_quotient(minus(sums.above, sums.below).value(), 1);
  row.area = rounded_quotient(whole.value(), 2);
  row.covered = rounded_quotient(sums.covered.value(), 2);
  row.mean = row.net / row.covered;
  const auto without = [&](const ExactSum& covered) {
    const double rest = rounded_quotient(minus(whole, covered).value(), 2);
    return rest > negligible * row.area ? rest : 0;
  };
  row.uncovered = without(sums.covered);
  row.uncovered_by_a = without(by_a);
  row.uncovered_by_b = without(by_b);
}

Result<Asked> read_request(const fs::path& a, const std::optional<fs::path>& b, const VolumeOptions& options) {
  BOOST_OUTCOME_TRYV(check_volume_options(b.has_value(), options));
  BOOST_OUTCOME_TRY(upper, Surface::open(a, options.value, {options.max_edge, options.max_radius}));
  Asked asked{.a = std::move(upper), .b = {}, .base = !options.base.empty(), .polygons = {}};
  const Manifest& manifest = asked.a.manifest();
  if (b) {
    BOOST_OUTCOME_TRY(lower, Surface::open(*b, options.value, {options.max_edge, options.max_radius}));
    BOOST_OUTCOME_TRYV(check_same_system(a, manifest.crs, *b, lower.manifest().crs));
    asked.b = std::move(lower);
  }
  const fs::path& file = asked.base ? options.base : options.within;
  if (file.empty()) return asked;
  BOOST_OUTCOME_TRY(
      polygons,
      read_polygons(file, {.name = options.name, .heights = asked.base, .bytes_max = options.memory_bytes / 4}));
  BOOST_OUTCOME_TRYV(polygons.frame.check_in(manifest.crs, manifest.bounds));
  asked.polygons = std::move(polygons);
  return asked;
}

void describe(const Asked& asked, Volumes& made) {
  const Manifest& manifest = asked.a.manifest();
  made.crs = manifest.crs;
  made.polygons = !asked.polygons.polygons.empty();
  const CoordinateUnits units = coordinate_units(manifest.crs);
  if (!units.horizontal.empty()) made.area_unit = units.horizontal + "^2";
  if (!units.horizontal.empty() && units.horizontal == units.vertical) made.volume_unit = units.horizontal + "^3";
  made.note = terrain::note_of(manifest, std::nullopt);
  if (!asked.b) return;
  if (const std::string other = terrain::note_of(asked.b->manifest(), std::nullopt); other != made.note)
    made.note += (made.note.empty() || other.empty() ? "" : "; ") + other;
}

}  // namespace
}  // namespace volume

Result<Volumes> volumes(const fs::path& a, const std::optional<fs::path>& b, const VolumeOptions& options,
                        std::stop_token stop) {
  BOOST_OUTCOME_TRY(asked, volume::read_request(a, b, options));
  Volumes made;
  volume::describe(asked, made);
  volume::Computation computation(asked, options, stop);
  BOOST_OUTCOME_TRYV(computation.run());
  made.long_edges = computation.long_edges();
  made.without_height = computation.without_height();
  auto& polygons = asked.polygons.polygons;
  for (std::size_t i = 0; i < computation.rows().size(); ++i) {
    const volume::RowSums& sums = computation.rows()[i];
    volume::MapPolygon* const polygon = polygons.empty() ? nullptr : &polygons[i];
    VolumeRow row;
    volume::fill_in(asked, polygon, sums, row);
    if (sums.too_large || !std::isfinite(row.cut) || !std::isfinite(row.fill) || !std::isfinite(row.area))
      return error(Errc::bad_input, a.string() + ": a volume between the surfaces is too large for a double");
    if (polygon != nullptr) {
      row.feature = polygon->feature;
      row.name = std::move(polygon->name);
      row.wkb = std::move(polygon->wkb);
    }
    made.rows.push_back(std::move(row));
  }
  return made;
}

}  // namespace tessera
