// One number per vertex of the export, from 0: own vertices tile by tile.
#pragma once

#include <cstdint>
#include <filesystem>
#include <stop_token>
#include <utility>
#include <vector>

#include "src/result/export/cell_filter.h"
#include "src/result/tile_source.h"

namespace tessera::exports {

// Remembers only the vertices that tiles share, 17 bytes each; the others are counted. With a filter:
// prepare, survey() each tile, then number_own() each, then of(). Without: prepare, number_own(), of().
class VertexNumbers {
 public:
  VertexNumbers() = default;
  // Finds the vertices that other tiles than their own use. Errors: of reading; interrupted.
  static Result<VertexNumbers> prepare(const TileSource& source, const CellFilter& filter, std::stop_token stop);
  // Notes which vertices of the manifest's `index`-th tile its cells use, those that the filter keeps.
  void survey(const TileMesh& mesh, std::size_t index);
  // By tile, once all are surveyed: how many own vertices cells use, its own or another tile's.
  std::vector<std::uint64_t> used_by_tile() const;
  // By vertex: 1 for a tile's own ones that are exported. Needs the cells only with a filter.
  std::vector<std::uint8_t> exported_own(const TileMesh& mesh) const;
  // Numbers those, in their order. REQUIRES: called for each tile in the manifest's order; `exported` as above.
  void number_own(const TileMesh& mesh, const std::vector<std::uint8_t>& exported);
  // The numbers of the vertices of the manifest's `index`-th tile, once all are numbered; any for those that are not
  // exported. Error corrupt: a vertex that nobody owns.
  Result<std::vector<std::uint64_t>> of(const TileMesh& mesh, std::size_t index,
                                        const std::filesystem::path& path) const;

 private:
  explicit VertexNumbers(const CellFilter& filter) : filter_(filter) {}
  std::size_t place(PointId id) const;  // in shared_; its size when the vertex is not shared

  CellFilter filter_{std::nullopt};
  std::vector<std::pair<PointId, std::uint64_t>> shared_;  // (id, number; while surveyed: its tile's index), by id
  std::vector<std::uint8_t> used_;                         // with a filter, of shared_: a cell that is kept has it
  std::vector<std::uint64_t> alone_;                       // by tile: own vertices that only its own cells use
  std::vector<std::uint64_t> first_;                       // by tile: the number of its first own vertex
  std::uint64_t next_ = 0;
};

}  // namespace tessera::exports
