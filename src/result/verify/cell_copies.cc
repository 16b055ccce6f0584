#include "src/result/verify/cell_copies.h"

#include <span>
#include <string>

namespace tessera {

namespace {

Status check_group(std::span<const CellCopy> group, int dimension, const TileSource& source) {
  const auto wrong = [&](const CellCopy& copy, const std::string& reason) {
    return wrong_cell(source, {copy.tile, copy.cell}, copy.ids, reason);
  };
  unsigned owned = 0;
  bool main = false;
  for (std::size_t i = 0; i < group.size(); ++i) {
    const CellCopy& copy = group[i];
    if (i > 0 && group[i - 1].tile == copy.tile && !source.period().any())
      return wrong(copy, "is also cell " + std::to_string(group[i - 1].cell) + " of the same file");
    if (copy.coordinates != group[0].coordinates)
      return wrong(copy, "has vertices at other places than in tile " + to_string(group[0].tile));
    if ((owned & copy.own) != 0) return wrong(copy, "has a vertex that is also another tile's own");
    owned |= copy.own;
    if (copy.main != 0 && copy.tile != group[0].tile)
      return wrong(copy, "is main here, but tile " + to_string(group[0].tile) + " holds it too");
    if (copy.main != 0 && copy.first == 0)
      return wrong(copy, "is main, but it is another copy in this tile that ought to be");
    if (copy.main != 0 && main) return wrong(copy, "is main twice");
    main |= copy.main != 0;
  }
  if (const unsigned all = (1U << (dimension + 1)) - 1; owned != all) {
    int missing = 0;
    while ((owned >> missing & 1U) != 0) ++missing;
    return wrong(group[0], "is missing in the tile that owns vertex " +
                               to_string(group[0].ids[static_cast<std::size_t>(missing)]));
  }
  if (!main) return wrong(group[0], "is main in no tile, though this tile is the lowest that holds it");
  return success();
}

}  // namespace

Status check_cell_copies(ExternalSort<CellCopy>& copies, int dimension, const TileSource& source) {
  return for_each_group(
      copies, 64, [](const CellCopy& a, const CellCopy& b) { return a.ids == b.ids; },
      [&](std::span<const CellCopy> group) { return check_group(group, dimension, source); });
}

}  // namespace tessera
