#include "src/result/terrain/tiles.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <numeric>
#include <utility>

#include "src/base/crs/crs.h"
#include "src/base/option.h"
#include "src/result/query/part.h"
#include "src/result/query/stored_triangulation.h"

namespace tessera::terrain {

namespace {

// The error of a box without points, with the bounds of the points.
Error nothing_there(const Bounds& all) {
  const auto side = [](const char* name, double a, double b) {
    std::array<char, 80> text{};
    std::snprintf(text.data(), text.size(), "%s from %.10g to %.10g", name, a, b);
    return std::string(text.data());
  };
  return error(Errc::usage, option("bbox") + ": no cell meets it; the points of the result lie at " +
                                side("x", all.lo.x, all.hi.x) + ", " + side("y", all.lo.y, all.hi.y));
}

}  // namespace

Status check_surface(const std::filesystem::path& out, const Manifest& manifest, const exports::CellSizes& sizes) {
  if (manifest.dimension != 2)
    return error(Errc::usage, out.string() + ": is a 3D result, which has no heights over a plane; triangulate with " +
                                  option("dim", "2"));
  return exports::check_sizes(sizes);
}

Status check_meets(const Manifest& manifest, const std::optional<Bounds>& box) {
  const Bounds& all = manifest.bounds;
  if (box && (box->lo.x > all.hi.x || box->hi.x < all.lo.x || box->lo.y > all.hi.y || box->hi.y < all.lo.y))
    return nothing_there(all);
  return success();
}

Result<std::vector<std::size_t>> tiles_meeting(const TileSource& source, const std::optional<Bounds>& box,
                                               const Looking& looking) {
  const Manifest& manifest = source.manifest();
  std::vector<std::size_t> tiles(source.tiles());
  std::iota(tiles.begin(), tiles.end(), std::size_t{0});
  const Bounds& all = manifest.bounds;
  if (!box || manifest.region) return tiles;  // a region has one tile
  const double width = std::min(box->hi.x, all.hi.x) - std::max(box->lo.x, all.lo.x);
  const double height = std::min(box->hi.y, all.hi.y) - std::max(box->lo.y, all.lo.y);
  const double whole = (all.hi.x - all.lo.x) * (all.hi.y - all.lo.y);
  if (width > 0 && height > 0 && width * height >= whole / 2) return tiles;
  BOOST_OUTCOME_TRY(result, query::StoredTriangulation::open(source, {.memory_bytes = looking.memory_bytes}));
  BOOST_OUTCOME_TRY(ids, result.tiles({.box = *box}, {.stop = looking.stop}));
  std::erase_if(tiles,
                [&](std::size_t i) { return !std::binary_search(ids.begin(), ids.end(), source.entry(i).tile); });
  if (tiles.empty()) return nothing_there(all);
  return tiles;
}

std::string note_of(const Manifest& manifest, const std::optional<Bounds>& box, std::uint64_t unknown_pixels) {
  std::string note = crs_note(manifest.crs);
  if (!query::knows(manifest, box.value_or(manifest.bounds)))
    note +=
        std::string(note.empty() ? "" : "; ") +
        "the region does not hold all cells of this box: the whole triangulation may have more or other cells there";
  if (unknown_pixels > 0)
    note += (note.empty() ? "" : "; ") + std::to_string(unknown_pixels) +
            " pixels have no value, because the region does not hold all of their natural neighbours";
  return note;
}

}  // namespace tessera::terrain
