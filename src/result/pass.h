// Runs a computation over all tiles of a result: each tile once, on threads, within a memory budget.
//
// The computation returns columns. For a tile it computes the values of all cells of the tile, and of the tile's own
// vertices, all of whose cells the tile has. A cell that several tiles have must get the same value in each of them.
// Values of foreign vertices come from the tiles that own them: a tile sends the values of a vertex to every tile that
// has one of the vertex's cells, because exactly these tiles have the vertex as a foreign one. In a periodic result
// the tile itself can be among these tiles, and all images of a point get the values of the point. Values, and what
// tiles send, are kept in a scratch folder, one file a tile. Memory holds only the tiles that are being worked on, and
// their values.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <span>
#include <stop_token>
#include <utility>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/result.h"
#include "src/result/tile_source.h"

namespace tessera {

struct PassColumn {
  bool of_cells = false;
  Attribute as;
};

// One array a column: the values of all cells or vertices of a tile, in the file's order.
using PassValues = std::vector<std::vector<std::byte>>;

struct PassOptions {
  unsigned threads = 1;
  std::uint64_t memory_bytes = 0;  // budget; a single tile may exceed it
  double tile_factor = 1.5;        // memory that the function needs for a tile, divided by the bytes of the tile's file
  std::stop_token stop = {};
  // Called with the fraction that is done, 0..1, by one thread at a time; may be null.
  std::function<void(double)> progress = {};
};

class Pass {
 public:
  // `scratch` is an empty folder.
  Pass(const TileSource& source, std::vector<PassColumn> columns, std::filesystem::path scratch, PassOptions options)
      : source_(source.stopped_by(options.stop)),
        columns_(std::move(columns)),
        scratch_(std::move(scratch)),
        options_(std::move(options)) {}

  // Computes the values of a tile. Called by several threads, once for each tile. The tile has cells and neighbours,
  // but no attributes.
  using Compute = std::function<Result<PassValues>(std::size_t index, const StoredTile& tile)>;
  // Receives the values of a tile, those of foreign vertices included. Called by several threads, once for each tile.
  using Consumer = std::function<Status(std::size_t index, const PassValues& values)>;
  // The most bytes that run() writes into the scratch folder.
  std::uint64_t scratch_bytes() const;
  // Errors: those of reading and of the two functions; corrupt when tiles contradict each other; io; interrupted.
  Status run(const Compute& compute, const Consumer& take);

 private:
  Status on_tiles(double from, double to, double tile_factor, const std::function<Status(std::size_t)>& work);
  Status put_down(std::size_t index, const StoredTile& tile, const PassValues& values);
  Status send(std::size_t index, const StoredTile& tile, const PassValues& values);
  Status append(std::size_t to, std::span<const std::byte> records);
  Result<PassValues> read_values(std::size_t index) const;
  Status fill_foreign(std::size_t index, PassValues& values) const;
  void fill_row(std::span<const std::byte> row, std::size_t vertex, PassValues& values) const;
  std::size_t row_bytes() const;  // of the values that are sent with a vertex, without its id

  TileSource source_;
  std::vector<PassColumn> columns_;
  std::filesystem::path scratch_;
  PassOptions options_;
  std::array<std::mutex, 64> appending_;  // locks, chosen by the receiving tile
};

}  // namespace tessera
