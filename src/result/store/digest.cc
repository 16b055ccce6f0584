#include "src/result/store/digest.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <utility>

#include "src/base/files/checksum.h"
#include "src/base/image.h"

namespace tessera {

namespace {

// The first digits of pi after the point: numbers that were not chosen to any end.
constexpr std::uint64_t keys[4] = {0x243f6a8885a308d3, 0x13198a2e03707344, 0xa4093822299f31d0, 0x082efa98ec4e6c89};

// The seeds differ for cells and vertices, and for 2D and 3D.
constexpr XXH64_hash_t vertex_seed(int dimension) { return static_cast<XXH64_hash_t>(2 * dimension); }
constexpr XXH64_hash_t cell_seed(int dimension) { return static_cast<XXH64_hash_t>(2 * dimension + 1); }

// Size and seed are known when this is inlined, so the compiler does most of the hash's work.
template <XXH64_hash_t seed, class Record>
[[gnu::always_inline]] inline Digest hash(const Record& record) {
  static_assert(std::endian::native == std::endian::little);
  const XXH128_hash_t value = XXH3_128bits_withSeed(&record, sizeof record, seed);
  return {value.low64, value.high64};
}

// The exclusive or of the two halves of the 128-bit product.
[[gnu::always_inline]] inline std::uint64_t folded(std::uint64_t a, std::uint64_t b) {
  const XXH128_hash_t product = XXH_mult64to128(a, b);
  return product.low64 ^ product.high64;
}

}  // namespace

CellDigest::CellDigest(int dimension, std::span<const PointId> ids, std::span<const std::uint8_t> offsets)
    : dimension_(dimension), of_vertex_(ids.size()) {
  if (!offsets.empty()) {
    ids_.assign(ids.begin(), ids.end());
    offsets_.assign(offsets.begin(), offsets.end());
  }
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const Digest id = dimension == 2 ? hash<cell_seed(2)>(ids[i]) : hash<cell_seed(3)>(ids[i]);
    of_vertex_[i] = {id.low, id.high};
  }
}

template <int D, bool flagged>
Digest CellDigest::sum(std::span<const std::int32_t> cells, const std::uint8_t* ghost) const {
  const HashHalves* const of_vertex = of_vertex_.data();
  Digest sum;
  const std::size_t count = cells.size() / (D + 1);
  const std::int32_t* cell = cells.data();
  for (std::size_t c = 0; c < count; ++c, cell += D + 1) {
    if constexpr (flagged) {
      if (ghost[c] != 0) continue;
    }
    std::uint64_t low = 0, high = 0;
    for (std::size_t k = 0; k <= D; ++k) {
      const HashHalves& vertex = of_vertex[static_cast<std::size_t>(cell[k])];
      low += vertex.low, high += vertex.high;
    }
    sum += Digest{folded(low ^ keys[0], high ^ keys[1]), folded(low ^ keys[2], high ^ keys[3])};
  }
  return sum;
}

// Most cells have no image among their vertices. They are hashed as in a cloud without a period.
template <int D>
Digest CellDigest::sum_of_images(std::span<const std::int32_t> cells, const std::uint8_t* ghost) const {
  const auto image_at = [&](std::int32_t v) {
    const auto i = static_cast<std::size_t>(v);
    return std::pair(ids_[i], image::offset(offsets_[i]));
  };
  const auto words_of = [&](std::span<const std::int32_t> cell) {
    auto least = image_at(cell[0]);
    for (const std::int32_t v : cell) least = std::min(least, image_at(v));
    HashHalves sum{0, 0};
    for (const std::int32_t v : cell) {
      const auto [id, offset] = image_at(v);
      const Digest word = hash<cell_seed(D)>(image_of(id, offset - least.second));
      sum.low += word.low, sum.high += word.high;
    }
    return sum;
  };
  Digest sum;
  for (std::size_t c = 0; c < cells.size() / (D + 1); ++c) {
    if (ghost != nullptr && ghost[c] != 0) continue;
    const auto cell = cells.subspan(c * (D + 1), D + 1);
    HashHalves words{0, 0};
    unsigned images = 0;
    for (const std::int32_t v : cell) {
      const auto i = static_cast<std::size_t>(v);
      images |= offsets_[i];
      words.low += of_vertex_[i].low, words.high += of_vertex_[i].high;
    }
    if (images != 0) words = words_of(cell);
    sum += Digest{folded(words.low ^ keys[0], words.high ^ keys[1]), folded(words.low ^ keys[2], words.high ^ keys[3])};
  }
  return sum;
}

Digest CellDigest::of(std::span<const std::int32_t> cells, const std::uint8_t* ghost) const {
  if (!offsets_.empty()) return dimension_ == 2 ? sum_of_images<2>(cells, ghost) : sum_of_images<3>(cells, ghost);
  if (dimension_ == 2) return ghost ? sum<2, true>(cells, ghost) : sum<2, false>(cells, ghost);
  return ghost ? sum<3, true>(cells, ghost) : sum<3, false>(cells, ghost);
}

namespace {

Digest of_vertex(int dimension, const LocalPoint& vertex) {
  return dimension == 2 ? hash<vertex_seed(2)>(vertex) : hash<vertex_seed(3)>(vertex);
}

}  // namespace

Digest digest_of(int dimension, std::span<const Point> points, std::span<const PointId> ids) {
  Digest sum;
  for (std::size_t i = 0; i < points.size(); ++i) sum += of_vertex(dimension, {points[i], ids[i]});
  return sum;
}

TileDigest::TileDigest(const TileMesh& mesh, std::size_t known, const Digest& sum)
    : mesh_(mesh), cells_(mesh.dimension, mesh.ids, mesh.offsets), next_(known), sum_(sum) {
  for (std::size_t i = 0; i < mesh.ids.size(); ++i) {
    if (mesh.point_ghost[i] != 0) continue;
    sum_ += of_vertex(mesh.dimension, {mesh.points[i], mesh.ids[i]});
  }
}

void TileDigest::add(std::span<const std::int32_t> cells) {
  sum_ += cells_.of(cells, mesh_.cell_ghost.data() + next_);
  next_ += cells.size() / (static_cast<std::size_t>(mesh_.dimension) + 1);
}

Digest digest_of(const TileMesh& mesh) {
  TileDigest digest(mesh);
  digest.add(mesh.cells);
  return digest.value();
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
