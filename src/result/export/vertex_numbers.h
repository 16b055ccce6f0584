// Numbers the vertices of an export from 0: own vertices tile by tile. In a periodic result an image that a cell has is
// a vertex of its own; it follows the own vertices of the first tile whose cells have it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <stop_token>
#include <utility>
#include <vector>

#include "src/result/export/cell_filter.h"
#include "src/result/tile_source.h"

namespace tessera::exports {

// Remembers only the vertices that tiles share, 17 bytes each, and images, 24 bytes each; the others are counted. Order
// of calls with a filter: prepare(), survey() for each tile, number_own() for each tile, of(). Without a filter:
// prepare(), number_own(), of().
class VertexNumbers {
 public:
  VertexNumbers() = default;
  // Finds the vertices that other tiles than their own tile use, and the images that exported cells have. Without
  // `images_apart`, an image is the same vertex as its point. Errors: those of reading; interrupted.
  static Result<VertexNumbers> prepare(const TileSource& source, const CellFilter& filter, bool images_apart,
                                       std::stop_token stop);
  // Notes which vertices of the manifest's `index`-th tile are used by cells that the filter keeps.
  void survey(const TileMesh& mesh, std::size_t index);
  // By tile, after all tiles were surveyed: the number of own vertices that cells of this or another tile use, without
  // images.
  std::vector<std::uint64_t> used_by_tile() const;
  // By tile: the number of images that come with the vertices of the tile. Empty without a period.
  const std::vector<std::uint64_t>& images_by_tile() const { return images_by_tile_; }
  // By vertex: 1 for those that are exported with the manifest's `index`-th tile. Reads the cells only with a filter.
  std::vector<std::uint8_t> exported_with(const TileMesh& mesh, std::size_t index) const;
  // Numbers the exported vertices, in their order. `exported` is what exported_with() returned. REQUIRES: called for
  // each tile in the manifest's order.
  void number_own(const TileMesh& mesh, const std::vector<std::uint8_t>& exported);
  // The numbers of the vertices of the manifest's `index`-th tile, after all tiles were numbered; the entries of
  // vertices that are not exported are arbitrary. Error corrupt for a vertex without an owner.
  Result<std::vector<std::uint64_t>> of(const TileMesh& mesh, std::size_t index,
                                        const std::filesystem::path& path) const;

 private:
  explicit VertexNumbers(const CellFilter& filter) : filter_(filter) {}
  std::size_t place(PointId id) const;  // index in shared_; its size when the vertex is not shared
  struct Image {
    PointId id;            // with the code of the offset (src/base/image.h)
    std::size_t tile = 0;  // index of the first tile whose exported cells have the image
    std::uint64_t number = 0;
  };
  bool is_image(const TileMesh& mesh, std::size_t vertex) const;
  // Adds the images that exported cells of the tile have.
  void find_images(const TileMesh& mesh, std::size_t index);
  // The image that is this vertex; null when no exported cell has it.
  const Image* image(const TileMesh& mesh, std::size_t vertex) const;
  Image* image(const TileMesh& mesh, std::size_t vertex) {
    return const_cast<Image*>(std::as_const(*this).image(mesh, vertex));
  }

  CellFilter filter_{CellSizes{}};
  bool images_apart_ = false;
  std::vector<std::pair<PointId, std::uint64_t>> shared_;  // (id, number; while surveyed: index of its tile), by id
  std::vector<std::uint8_t> used_;                         // with a filter, by index in shared_: a kept cell has it
  std::vector<std::uint64_t> alone_;                       // by tile: own vertices that only its own cells use
  std::vector<std::uint64_t> first_;                       // by tile: the number of its first own vertex
  std::vector<Image> images_;                              // by id
  std::vector<std::uint64_t> images_by_tile_;
  std::uint64_t next_ = 0;
};

}  // namespace tessera::exports
