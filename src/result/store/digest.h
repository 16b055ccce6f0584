// What two results of the same triangulation have in common, whatever tiles, threads and nodes made them: the sum,
// modulo 2^128, of a hash of every cell and of every vertex.
//  (1) A cell is hashed by its vertices' source ids; a vertex by its id and the bits of its coordinates; both with the
//      dimension. What order things stand in, and which way a cell is written down, does not matter.
//  (2) Each cell is main in one tile and each vertex is one tile's own, so the digest of a result is the sum of its
//      tiles' digests.
//  (3) Different triangulations have the same digest with a probability of about 2^-128: no accident does it. Who sets
//      out to make two such triangulations can, as hash and sum are no cryptography.
// Attributes are not part of it.
//
// A cell's hash costs a vertex one XXH3-128 of its id, two 64-bit words that stand for it in all of its cells. In a
// cell the words are added, which forgets their order and nothing else: as good as random, the sums of two different
// sets of vertices agree with a probability of 2^-128, and where a few did, a digest would still have to agree in all
// the rest. Sums of sums would be worth little: the sum over all cells would tell how many cells each vertex has, no
// more. So the two sums are multiplied, twice with different keys, and the product's halves folded into one: no sum of
// products is left of it, of which the number of cells around each edge would be enough.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "src/base/big_vector.h"
#include "src/geometry/mesh/tile_mesh.h"

namespace tessera {

struct Digest {
  std::uint64_t low = 0;
  std::uint64_t high = 0;
  // Modulo 2^128.
  Digest& operator+=(const Digest& other) {
    low += other.low;
    high += other.high + (low < other.low ? 1 : 0);
    return *this;
  }
  friend bool operator==(const Digest&, const Digest&) = default;
};

// Of cells that are told by indices into `ids`.
class CellDigest {
 public:
  CellDigest(int dimension, std::span<const PointId> ids);
  // Rows of dimension + 1 vertices. Those do not count whose flag in `ghost` is set; none: all do.
  Digest of(std::span<const std::int32_t> cells, const std::uint8_t* ghost = nullptr) const;

 private:
  struct Words {
    std::uint64_t low, high;
  };
  template <int D, bool flagged>
  Digest sum(std::span<const std::int32_t> cells, const std::uint8_t* ghost) const;

  int dimension_;
  BigVector<Words> of_vertex_;
};

// Of vertices.
Digest digest_of(int dimension, std::span<const Point> points, std::span<const PointId> ids);

// Of a tile's main cells and own vertices, as the cells come. REQUIRES: cells are indices into points.
class TileDigest {
 public:
  // Refers to the mesh, of which it does not look at the cells; `known` of them are taken as added, and have `sum`.
  explicit TileDigest(const TileMesh& mesh, std::size_t known = 0, const Digest& sum = {});
  // The vertices of the next cells: rows of dimension + 1.
  void add(std::span<const std::int32_t> cells);
  Digest value() const { return sum_; }

 private:
  const TileMesh& mesh_;
  CellDigest cells_;
  std::size_t next_;  // cell
  Digest sum_;
};
Digest digest_of(const TileMesh& mesh);

// 32 lower-case hexadecimal digits, and back; nothing for any other text.
std::string digest_text(const Digest& digest);
std::optional<Digest> parse_digest(std::string_view text);

}  // namespace tessera
