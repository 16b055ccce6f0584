// What two results of the same triangulation have in common, whatever tiles, threads and nodes made them: the sum,
// modulo 2^128, of an XXH3-128 hash of every cell and of every vertex.
//  (1) A cell is hashed by its vertices' source ids, sorted; a vertex by its id and the bits of its coordinates; both
//      with the dimension. What order things stand in, and which way a cell is written down, does not matter.
//  (2) Each cell is main in one tile and each vertex is one tile's own, so the digest of a result is the sum of its
//      tiles' digests.
//  (3) Different triangulations have the same digest with a probability of about 2^-128: no accident does it. Who sets
//      out to make two such triangulations can, as hash and sum are no cryptography.
// Attributes are not part of it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "src/mesh/tile_mesh.h"

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

// Of the tile's main cells and own vertices. REQUIRES: cells are indices into points.
Digest digest_of(const TileMesh& mesh);

// 32 lower-case hexadecimal digits, and back; nothing for any other text.
std::string digest_text(const Digest& digest);
std::optional<Digest> parse_digest(std::string_view text);

}  // namespace tessera
