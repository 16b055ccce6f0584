// The digest of a triangulation: the sum, modulo 2^128, of a hash of every cell and of every vertex. Two results of the
// same triangulation have the same digest, whatever tiles, threads and nodes made them.
//  (1) A cell is hashed by the source ids of its vertices; a vertex by its id and the bits of its coordinates; both
//      with the dimension. The order of cells and vertices does not matter, nor the order of the vertices in a cell.
//      In a periodic cloud a cell is hashed by images (src/base/image.h), after a shift by which the vertex with the
//      least id, and of its images the least, gets the offset 0. So the hash does not depend on where the cell lies.
//  (2) Each cell is main in one tile, and each vertex is one tile's own. So the digest of a result is the sum of the
//      digests of its tiles.
//  (3) Two different triangulations have the same digest with a probability of about 2^-128. The hash and the sum are
//      not cryptographic: an attacker can construct two triangulations with the same digest.
//
// The digest does not cover attributes.
//
// For a cell's hash, each vertex costs one XXH3-128 of its id. The result is two 64-bit words, which stand for the
// vertex in all of its cells. The words of a cell's vertices are added, so only their order is lost: the sums of two
// different sets of vertices agree with a probability of 2^-128, as for a random function, and even if a few did, the
// digest would still depend on all other cells. Adding these sums over all cells would be too weak, because the total
// would only tell how many cells each vertex has. So the two sums of a cell are multiplied, twice with different keys,
// and the halves of each product are folded into one word. Without the folding a sum of products would remain, which
// depends only on the number of cells around each edge.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/big_vector.h"
#include "src/geometry/mesh/tile_mesh.h"

namespace tessera {

struct Digest {
  std::uint64_t low = 0;
  std::uint64_t high = 0;
  // Adds modulo 2^128.
  Digest& operator+=(const Digest& other) {
    low += other.low;
    high += other.high + (low < other.low ? 1 : 0);
    return *this;
  }
  friend bool operator==(const Digest&, const Digest&) = default;
};

// Computes digests of cells that are given as indices into `ids`.
class CellDigest {
 public:
  // `offsets`: beside ids, codes of offsets; empty: all are 0. REQUIRES: offsets of one cell are near each other.
  CellDigest(int dimension, std::span<const PointId> ids, std::span<const std::uint8_t> offsets = {});
  // `cells` has rows of dimension + 1 vertices. Cells whose flag in `ghost` is set are left out; without flags all
  // cells are counted.
  Digest of(std::span<const std::int32_t> cells, const std::uint8_t* ghost = nullptr) const;

 private:
  struct HashHalves {
    std::uint64_t low, high;
  };
  template <int D, bool flagged>
  Digest sum(std::span<const std::int32_t> cells, const std::uint8_t* ghost) const;
  template <int D>
  Digest sum_of_images(std::span<const std::int32_t> cells, const std::uint8_t* ghost) const;

  int dimension_;
  BigVector<HashHalves> of_vertex_;
  // Both empty when all offsets are 0.
  std::vector<PointId> ids_;
  std::vector<std::uint8_t> offsets_;
};

// The digest of vertices.
Digest digest_of(int dimension, std::span<const Point> points, std::span<const PointId> ids);

// The digest of a tile's main cells and own vertices, computed while the cells arrive. REQUIRES: the cells are indices
// into the mesh's points.
class TileDigest {
 public:
  // Keeps a reference to the mesh, but does not read the mesh's cells. The first `known` cells count as added already,
  // with the digest `sum`.
  explicit TileDigest(const TileMesh& mesh, std::size_t known = 0, const Digest& sum = {});
  // Adds the next cells, as rows of dimension + 1 vertices.
  void add(std::span<const std::int32_t> cells);
  Digest value() const { return sum_; }

 private:
  const TileMesh& mesh_;
  CellDigest cells_;
  std::size_t next_;  // number of the next cell
  Digest sum_;
};
Digest digest_of(const TileMesh& mesh);

// The digest as 32 lower-case hexadecimal digits, and the inverse, which returns nothing for any other text.
std::string digest_text(const Digest& digest);
std::optional<Digest> parse_digest(std::string_view text);

}  // namespace tessera
