// Puts a tile's points into Hilbert order, each once.
#include <algorithm>
#include <array>
#include <bit>
#include <span>
#include <tuple>
#include <utility>

#include "src/base/big_vector.h"
#include "src/tiling/hilbert.h"
#include "src/tiling/routed_cloud.h"

namespace tessera {
namespace {

struct Entry {
  std::uint64_t key, index;
};
using Entries = BigVector<Entry>;

constexpr int digit_bits = 11;  // 2048 counters: the scatter's targets stay in the second-level cache
constexpr int digits = 6;       // 66 >= 63 bits

// A radix sort, least significant digit first, with all histograms made in one pass; a digit that is equal in all keys
// costs nothing. In 2D the lowest digits seldom matter. So only enough digits are sorted for 32 cells of the curve per
// point, and the few entries that are then equal are sorted by comparison.
void sort_by_key(Entries& entries, int dimension) {
  constexpr std::size_t few = 512;  // below this, clearing the counters is not worth it
  if (entries.size() < few) {
    return std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.key < b.key; });
  }
  constexpr std::size_t buckets = std::size_t{1} << digit_bits;
  std::vector<std::array<std::size_t, buckets>> counts(digits);
  for (const Entry& e : entries) {
    for (int d = 0; d < digits; ++d) ++counts[d][(e.key >> (d * digit_bits)) % buckets];
  }
  constexpr int planar_bits = 62;
  const int needed = static_cast<int>(std::bit_width(entries.size())) + 5;
  const int first = dimension == 2 ? std::max(planar_bits - needed, 0) / digit_bits : 0;
  Entries other(entries.size());
  for (int d = first; d < digits; ++d) {
    auto& count = counts[d];
    const int shift = d * digit_bits;
    if (entries.empty() || count[(entries[0].key >> shift) % buckets] == entries.size()) continue;
    std::size_t begin = 0;
    for (std::size_t& c : count) begin += std::exchange(c, begin);
    for (const Entry& e : entries) other[count[(e.key >> shift) % buckets]++] = e;
    entries.swap(other);
  }
  if (first == 0) return;
  const int left_out = first * digit_bits;
  for (std::size_t begin = 0, end = 0; begin < entries.size(); begin = end) {
    while (end < entries.size() && entries[end].key >> left_out == entries[begin].key >> left_out) ++end;
    if (end - begin == 1) continue;
    std::sort(entries.begin() + static_cast<std::ptrdiff_t>(begin), entries.begin() + static_cast<std::ptrdiff_t>(end),
              [](const Entry& a, const Entry& b) { return a.key < b.key; });
  }
}

class Sorter {
 public:
  Sorter(std::span<const LocalPoint> points, int dimension) : points_(points), dimension_(dimension) {}

  // Sorts by Hilbert key within the bounds of these points, and entries with equal keys by sort_run().
  void sort(Entries& entries) const {
    Bounds bounds;
    for (const Entry& e : entries) bounds.add(points_[e.index].at);
    const HilbertKey key(bounds, dimension_);
    for (Entry& e : entries) e.key = key(points_[e.index].at);
    sort_by_key(entries, dimension_);
    for (std::size_t begin = 0, end = 0; begin < entries.size(); begin = end) {
      while (end < entries.size() && entries[end].key == entries[begin].key) ++end;
      if (end - begin > 1) sort_run(std::span(entries).subspan(begin, end - begin));
    }
  }

 private:
  static constexpr std::size_t long_run = 1024;

  // A few points in one cell of the curve are sorted lexicographically. Many points share a cell when density spans
  // many octaves (outliers, clusters in clusters). They get a curve of their own; each such curve is 2^21 times finer,
  // so this ends after a few.
  void sort_run(std::span<Entry> run) const {
    const Point& first = points_[run[0].index].at;
    const bool all_equal =
        std::all_of(run.begin(), run.end(), [&](const Entry& e) { return points_[e.index].at == first; });
    if (run.size() < long_run || all_equal) {
      std::sort(run.begin(), run.end(), [&](const Entry& a, const Entry& b) {
        const LocalPoint& p = points_[a.index];
        const LocalPoint& q = points_[b.index];
        return std::tie(p.at.x, p.at.y, p.at.z, p.id) < std::tie(q.at.x, q.at.y, q.at.z, q.id);
      });
      return;
    }
    Entries entries(run.begin(), run.end());
    sort(entries);
    std::copy(entries.begin(), entries.end(), run.begin());
  }

  std::span<const LocalPoint> points_;
  int dimension_;
};

}  // namespace

LoadedTile order_points(std::span<const LocalPoint> points, int dimension) {
  Entries entries(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) entries[i] = {0, i};
  Sorter(points, dimension).sort(entries);

  LoadedTile tile;
  // Room for foreign vertices. It costs no memory until it is used, and the same arrays later become the mesh's.
  const std::size_t most = points.size() + points.size() / 8;
  tile.points.reserve(most);
  tile.ids.reserve(most);
  // Equal coordinates have equal keys on every curve. So equal points are neighbours now, the lowest id first.
  for (const Entry& e : entries) {
    const LocalPoint& p = points[e.index];
    if (!tile.points.empty() && tile.points.back() == p.at) {
      tile.duplicates.emplace_back(p.id, tile.ids.back());
    } else {
      tile.points.push_back(p.at);
      tile.ids.push_back(p.id);
    }
  }
  std::sort(tile.duplicates.begin(), tile.duplicates.end());
  return tile;
}

}  // namespace tessera
