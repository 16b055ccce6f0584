// A source of a tile's cells, one after the other. A reader that writes cells to a file needs no arrays of them.
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "src/base/result.h"

namespace tessera {

// Both functions call `take` with the numbers in the order of the tile's mesh. Each call gets whole rows of dimension +
// 1 numbers. When `take` fails, the function stops and returns that failure.
class CellStream {
 public:
  using Consumer = std::function<Status(std::span<const std::int32_t>)>;
  virtual ~CellStream() = default;
  virtual Status vertices(const Consumer& take) const = 0;   // the numbers of TileMesh::cells
  virtual Status neighbors(const Consumer& take) const = 0;  // the numbers of TileMesh::neighbors
};

}  // namespace tessera
