// One number per vertex of the result, from 0: own vertices tile by tile.
#pragma once

#include <cstdint>
#include <filesystem>
#include <stop_token>
#include <utility>
#include <vector>

#include "src/store/tile_store.h"

namespace tessera::exports {

// Remembers only the vertices that tiles share, 16 bytes each; the others are counted.
class VertexNumbers {
 public:
  // Finds the vertices that other tiles than their own use. Errors: of read_tile_vertices(), interrupted.
  static Result<VertexNumbers> prepare(const std::filesystem::path& out, const Manifest& manifest,
                                       std::stop_token stop);
  // Numbers a tile's own vertices, in their order. REQUIRES: called for each tile in the manifest's order.
  void number_own(const TileMesh& mesh);
  // The numbers of the vertices of the manifest's `index`-th tile, once all are numbered. Error corrupt: a vertex that
  // nobody owns.
  Result<std::vector<std::uint64_t>> of(const TileMesh& mesh, std::size_t index,
                                        const std::filesystem::path& path) const;

 private:
  std::vector<std::pair<PointId, std::uint64_t>> foreign_;  // (id, number), by id
  std::vector<std::uint64_t> first_;                        // by tile: the number of its first own vertex
  std::uint64_t next_ = 0;
};

}  // namespace tessera::exports
