#include "src/store/digest.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <array>
#include <bit>
#include <charconv>

#include "src/files/checksum.h"

namespace tessera {

namespace {

// Seeds keep cells and vertices of either dimension apart.
constexpr XXH64_hash_t vertex_seed(int dimension) { return static_cast<XXH64_hash_t>(2 * dimension); }
constexpr XXH64_hash_t cell_seed(int dimension) { return static_cast<XXH64_hash_t>(2 * dimension + 1); }

// Size and seed are known where it is inlined: most of the hash's work is then done by the compiler.
template <XXH64_hash_t seed, class Record>
[[gnu::always_inline]] inline Digest hash(const Record& record) {
  static_assert(std::endian::native == std::endian::little);
  const XXH128_hash_t value = XXH3_128bits_withSeed(&record, sizeof record, seed);
  return {value.low64, value.high64};
}

// A sorting network: no branch depends on what is sorted.
template <std::size_t N>
void sort(std::array<std::uint64_t, N>& ids) {
  const auto order = [&](std::size_t a, std::size_t b) {
    const std::uint64_t least = ids[a] < ids[b] ? ids[a] : ids[b];
    ids[b] = ids[a] < ids[b] ? ids[b] : ids[a];
    ids[a] = least;
  };
  if constexpr (N == 3) {
    order(0, 1), order(1, 2), order(0, 1);
  } else {
    order(0, 1), order(2, 3), order(0, 2), order(1, 3), order(1, 2);
  }
}

template <int D>
Digest digest_of_tile(const TileMesh& mesh) {
  Digest sum;
  const std::int32_t* cell = mesh.cells.data();
  for (std::size_t c = 0; c < mesh.cell_ghost.size(); ++c, cell += D + 1) {
    if (mesh.cell_ghost[c] != 0) continue;
    std::array<std::uint64_t, D + 1> ids;
    for (std::size_t k = 0; k <= D; ++k) ids[k] = mesh.ids[static_cast<std::size_t>(cell[k])].value;
    sort(ids);
    sum += hash<cell_seed(D)>(ids);
  }
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    if (mesh.point_ghost[i] == 0) sum += hash<vertex_seed(D)>(LocalPoint{mesh.points[i], mesh.ids[i]});
  }
  return sum;
}

}  // namespace

Digest digest_of(const TileMesh& mesh) {
  return mesh.dimension == 2 ? digest_of_tile<2>(mesh) : digest_of_tile<3>(mesh);
}

std::string digest_text(const Digest& digest) { return checksum_text(digest.high) + checksum_text(digest.low); }

std::optional<Digest> parse_digest(std::string_view text) {
  if (text.size() != 32 || text.find_first_not_of("0123456789abcdef") != std::string_view::npos) return std::nullopt;
  Digest digest;
  std::from_chars(text.data(), text.data() + 16, digest.high, 16);
  std::from_chars(text.data() + 16, text.data() + 32, digest.low, 16);
  return digest;
}

}  // namespace tessera
