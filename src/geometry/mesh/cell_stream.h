// The cells of a tile one after the other, for whoever writes them down: nobody need have them as arrays.
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "src/base/result.h"

namespace tessera {

// Both in the order of the tile's mesh, in pieces of whole rows of dimension + 1 numbers. The first failure of `take`
// ends it and is returned.
class CellStream {
 public:
  using Take = std::function<Status(std::span<const std::int32_t>)>;
  virtual ~CellStream() = default;
  virtual Status vertices(const Take& take) const = 0;   // as TileMesh::cells
  virtual Status neighbors(const Take& take) const = 0;  // as TileMesh::neighbors
};

}  // namespace tessera
