#include "src/delaunay/update/select_points.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <utility>

#include "src/base/attribute.h"
#include "src/base/on_threads.h"
#include "src/base/stopped.h"
#include "src/tiling/tile/changed_points.h"

namespace tessera {
namespace {

constexpr const char* class_attribute = "classification";

// Where the class stands in a row. Error usage when no row has one.
Result<std::size_t> place_of_class(const TileSource& source) {
  std::size_t at = 0;
  for (const Attribute& attribute : source.manifest().schema) {
    if (attribute.name == class_attribute && attribute.type == AttributeType::u8) return at;
    at += size_of(attribute.type);
  }
  return error(Errc::usage, source.folder().string() + ": the result has no attribute '" + class_attribute +
                                "' of 8 bits, so its points have no classes");
}

bool meets(const Box& tile, const Box& box, int dimension) {
  for (int axis = 0; axis < dimension; ++axis) {
    if (tile.lo[axis] > box.hi[axis] || tile.hi[axis] < box.lo[axis]) return false;
  }
  return true;
}

bool inside(const Point& p, const Box& box, int dimension) {
  for (int axis = 0; axis < dimension; ++axis) {
    if (p[axis] < box.lo[axis] || p[axis] > box.hi[axis]) return false;
  }
  return true;
}

Status select_in_tile(const TileSource& source, std::size_t index, const PointSelection& selection,
                      std::size_t class_at, std::vector<PointId>& out) {
  const Manifest& manifest = source.manifest();
  const std::size_t width = row_bytes(manifest.schema);
  BOOST_OUTCOME_TRY(tile, source.read(index, {.cells = false, .rows = !selection.classes.empty()}));
  for (std::size_t v = 0; v < tile.mesh.ids.size(); ++v) {
    if (tile.mesh.point_ghost[v] != 0) continue;
    bool wanted = selection.box && inside(tile.mesh.points[v], *selection.box, manifest.dimension);
    if (!selection.classes.empty()) {
      const int of_point = std::to_integer<int>(tile.rows[v * width + class_at]);
      wanted |= std::find(selection.classes.begin(), selection.classes.end(), of_point) != selection.classes.end();
    }
    if (wanted) out.push_back(tile.mesh.ids[v]);
  }
  return success();
}

}  // namespace

Result<std::vector<PointId>> select_points(const TileSource& source, const PointSelection& selection, unsigned threads,
                                           const std::stop_token& stop) {
  const Manifest& manifest = source.manifest();
  std::size_t class_at = 0;
  if (!selection.classes.empty()) {
    BOOST_OUTCOME_TRY(at, place_of_class(source));
    class_at = at;
  }
  std::vector<std::size_t> tiles;
  for (std::size_t i = 0; i < source.tiles(); ++i) {
    const Box& box = manifest.boxes.at(source.entry(i).tile.value);
    const bool in_box = selection.box && meets(box, *selection.box, manifest.dimension);
    if (!selection.classes.empty() || in_box) tiles.push_back(i);
  }
  std::mutex mutex;
  std::vector<PointId> selected;
  std::atomic<bool> failed{false};
  std::atomic<std::size_t> next{0};
  BOOST_OUTCOME_TRYV(on_threads(threads, failed, [&]() -> Status {
    for (std::size_t i = next++; i < tiles.size() && !failed; i = next++) {
      throw_if_stopped(stop);
      std::vector<PointId> of_tile;
      BOOST_OUTCOME_TRYV(select_in_tile(source, tiles[i], selection, class_at, of_tile));
      const std::lock_guard lock(mutex);
      selected.insert(selected.end(), of_tile.begin(), of_tile.end());
    }
    return success();
  }));
  if (manifest.duplicates_xxh3 != 0 && !selected.empty()) {
    const PointIds vertices(selected.begin(), selected.end());
    BOOST_OUTCOME_TRY(pairs, read_duplicates(source.folder(), manifest));
    for (const DuplicatePair& pair : pairs) {
      if (vertices.contains(pair.kept)) selected.push_back(pair.duplicate);
    }
  }
  std::sort(selected.begin(), selected.end());
  return selected;
}

}  // namespace tessera
