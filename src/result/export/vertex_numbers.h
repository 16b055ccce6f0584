// Numbers the vertices of an export from 0: own vertices tile by tile.
#pragma once

#include <cstdint>
#include <filesystem>
#include <stop_token>
#include <utility>
#include <vector>

#include "src/result/export/cell_filter.h"
#include "src/result/tile_source.h"

namespace tessera::exports {

// Remembers only the vertices that tiles share, 17 bytes each; the others are counted. Order of calls with a filter:
// prepare(), survey() for each tile, number_own() for each tile, of(). Without a filter: prepare(), number_own(), of().
class VertexNumbers {
 public:
  VertexNumbers() = default;
  // Finds the vertices that other tiles than their own tile use. Errors: those of reading; interrupted.
  static Result<VertexNumbers> prepare(const TileSource& source, const CellFilter& filter, std::stop_token stop);
  // Notes which vertices of the manifest's `index`-th tile are used by cells that the filter keeps.
  void survey(const TileMesh& mesh, std::size_t index);
  // By tile, after all tiles were surveyed: the number of own vertices that cells of this or another tile use.
  std::vector<std::uint64_t> used_by_tile() const;
  // By vertex: 1 for own vertices that are exported. Reads the cells only with a filter.
  std::vector<std::uint8_t> exported_own(const TileMesh& mesh) const;
  // Numbers the exported vertices, in their order. `exported` is what exported_own() returned. REQUIRES: called for
  // each tile in the manifest's order.
  void number_own(const TileMesh& mesh, const std::vector<std::uint8_t>& exported);
  // The numbers of the vertices of the manifest's `index`-th tile, after all tiles were numbered; the entries of
  // vertices that are not exported are arbitrary. Error corrupt for a vertex without an owner.
  Result<std::vector<std::uint64_t>> of(const TileMesh& mesh, std::size_t index,
                                        const std::filesystem::path& path) const;

 private:
  explicit VertexNumbers(const CellFilter& filter) : filter_(filter) {}
  std::size_t place(PointId id) const;  // index in shared_; its size when the vertex is not shared

  CellFilter filter_{CellSizes{}};
  std::vector<std::pair<PointId, std::uint64_t>> shared_;  // (id, number; while surveyed: index of its tile), by id
  std::vector<std::uint8_t> used_;                         // with a filter, by index in shared_: a kept cell has it
  std::vector<std::uint64_t> alone_;                       // by tile: own vertices that only its own cells use
  std::vector<std::uint64_t> first_;                       // by tile: the number of its first own vertex
  std::uint64_t next_ = 0;
};

}  // namespace tessera::exports
