// A sleeping tile as bytes: counts first, then flat arrays. Read back on the machine and by the version that wrote it,
// so layout and byte order are the memory's own; lengths and ranges are checked all the same.
#include <cstring>
#include <type_traits>

#include "src/tile/tile_triangulation.h"

namespace tessera {
namespace {

constexpr std::uint64_t magic = 0x3265676d49454c54u;

class Writer {
 public:
  template <class T>
  void value(const T& v) {
    static_assert(std::is_trivially_copyable_v<T>);
    const auto* p = reinterpret_cast<const std::byte*>(&v);
    bytes_.insert(bytes_.end(), p, p + sizeof(T));
  }
  template <class List>
  void list(const List& v) {
    using T = typename List::value_type;
    static_assert(std::is_trivially_copyable_v<T>);
    value(static_cast<std::uint64_t>(v.size()));
    const auto* p = reinterpret_cast<const std::byte*>(v.data());
    bytes_.insert(bytes_.end(), p, p + v.size() * sizeof(T));
  }
  void reserve(std::size_t n) { bytes_.reserve(n); }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : rest_(bytes) {}
  template <class T>
  bool value(T& v) {
    if (rest_.size() < sizeof(T)) return false;
    std::memcpy(&v, rest_.data(), sizeof(T));
    rest_ = rest_.subspan(sizeof(T));
    return true;
  }
  template <class List>
  bool list(List& v) {
    using T = typename List::value_type;
    std::uint64_t n = 0;
    if (!value(n) || n > rest_.size() / sizeof(T)) return false;
    v.resize(n);
    if (n > 0) std::memcpy(v.data(), rest_.data(), n * sizeof(T));
    rest_ = rest_.subspan(n * sizeof(T));
    return true;
  }
  bool at_end() const { return rest_.empty(); }

 private:
  std::span<const std::byte> rest_;
};

struct KnownForeign {
  std::uint64_t id;
  std::uint64_t vertex;
};

}  // namespace

std::vector<std::byte> TileTriangulation::save() const {
  Writer out;
  const KernelImage image = kernel_->save();
  const std::vector<std::uint64_t> sent = sent_.keys();
  out.reserve(image.points.size() * 48 + image.cells.vertices.size() * 8 + sent.size() * 8 + foreign_.size() * 16 +
              open_cells_.size() * 16 + 1024);
  out.value(magic);
  out.value(options_.self.value);
  out.value(static_cast<std::int32_t>(options_.dimension));
  out.value(static_cast<std::uint8_t>(reduced_));
  out.value(counts_);
  out.value(static_cast<std::int32_t>(image.dimension));
  out.list(image.points);
  out.list(image.local);
  out.list(image.alive);
  out.list(image.cells.vertices);
  out.list(image.cells.neighbors);
  out.value(image.frozen);
  out.list(ids_);
  out.list(owners_);
  out.list(ranks_);
  std::vector<KnownForeign> foreign;
  foreign.reserve(foreign_.size());
  for (const auto& [id, vertex] : foreign_) foreign.push_back({id, vertex});
  out.list(foreign);
  out.list(sent);
  out.list(std::vector<CellKey>(open_cells_.begin(), open_cells_.end()));
  return out.take();
}

bool TileTriangulation::load(std::span<const std::byte> bytes) {
  Reader in(bytes);
  std::uint64_t found = 0;
  std::uint32_t self = 0;
  std::int32_t dimension = 0;
  std::uint8_t reduced = 0;
  ExchangeCounts counts;
  KernelImage image;
  std::vector<std::uint64_t> ids, sent;
  std::vector<std::uint32_t> owners, ranks;
  std::vector<KnownForeign> foreign;
  std::vector<CellKey> open_cells;
  const bool read = in.value(found) && found == magic && in.value(self) && self == options_.self.value &&
                    in.value(dimension) && dimension == options_.dimension && in.value(reduced) && in.value(counts) &&
                    in.value(image.dimension) && in.list(image.points) && in.list(image.local) &&
                    in.list(image.alive) && in.list(image.cells.vertices) && in.list(image.cells.neighbors) &&
                    in.value(image.frozen) && in.list(ids) && in.list(owners) && in.list(ranks) && in.list(foreign) &&
                    in.list(sent) && in.list(open_cells) && in.at_end();
  if (!read) return false;
  const std::size_t n = image.points.size() + 1;
  if (ids.size() != n || owners.size() != n || (reduced ? ranks.size() != n : !ranks.empty())) return false;
  for (const auto& f : foreign) {
    if (f.vertex >= n) return false;
  }
  for (const std::uint64_t key : sent) {
    if (key >> 32 >= n) return false;
  }
  if (!kernel_->load(image)) return false;
  ids_ = std::move(ids);
  owners_ = std::move(owners);
  ranks_ = std::move(ranks);
  reduced_ = reduced != 0;
  counts_ = counts;
  foreign_.clear();
  for (const auto& f : foreign) foreign_[f.id] = static_cast<Vertex>(f.vertex);
  sent_ = {};
  for (const std::uint64_t key : sent) sent_.add(static_cast<Vertex>(key >> 32), static_cast<std::uint32_t>(key));
  open_cells_ = {open_cells.begin(), open_cells.end()};
  updates_.clear();
  return true;
}

}  // namespace tessera
