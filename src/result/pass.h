// A computation over all tiles of a result: every tile once, on threads, within a budget of memory.
//
// What is computed are columns. The function computes them of a tile's cells, also of those that are main elsewhere,
// for which it must give the same values there; and of the tile's own vertices, all cells of which the tile has. Values
// of foreign vertices come from the tiles that own them: a tile sends what it has found of a vertex to all tiles that
// hold one of its cells, for those are the tiles that have the vertex as a foreign one. Values and what is sent are put
// down in a scratch folder, a file a tile: in memory are the tiles that are worked on, and their values.
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

// By column: a value a cell or a vertex of a tile, in the file's order.
using PassValues = std::vector<std::vector<std::byte>>;

struct PassOptions {
  unsigned threads = 1;
  std::uint64_t memory_bytes = 0;  // at least what a tile takes is used
  double tile_factor = 1.5;        // what the function takes for a tile, in bytes of its file
  std::stop_token stop = {};
  // Told the part that is done, by one thread at a time; or null.
  std::function<void(double)> progress = {};
};

class Pass {
 public:
  // `scratch`: an empty folder.
  Pass(TileSource source, std::vector<PassColumn> columns, std::filesystem::path scratch, PassOptions options)
      : source_(source.stopped_by(options.stop)),
        columns_(std::move(columns)),
        scratch_(std::move(scratch)),
        options_(std::move(options)) {}

  // Called by several threads, for each tile once. The tile has cells and neighbours, without attributes.
  using Compute = std::function<Result<PassValues>(std::size_t index, const StoredTile& tile)>;
  // The same, with all values in their places.
  using Take = std::function<Status(std::size_t index, const PassValues& values)>;
  // That run() puts down in the scratch folder, at most.
  std::uint64_t scratch_bytes() const;
  // Errors: of reading, of the functions; corrupt when tiles contradict each other; io; interrupted.
  Status run(const Compute& compute, const Take& take);

 private:
  Status on_tiles(double from, double to, double tile_factor, const std::function<Status(std::size_t)>& work);
  Status put_down(std::size_t index, const StoredTile& tile, const PassValues& values);
  Status send(std::size_t index, const StoredTile& tile, const PassValues& values);
  Status append(std::size_t to, std::span<const std::byte> records);
  Result<PassValues> read_values(std::size_t index) const;
  Status fill_foreign(std::size_t index, PassValues& values) const;
  std::size_t row_bytes() const;  // of what is sent of a vertex, without its id

  TileSource source_;
  std::vector<PassColumn> columns_;
  std::filesystem::path scratch_;
  PassOptions options_;
  std::array<std::mutex, 64> appending_;  // by the tile that is sent to
};

}  // namespace tessera
