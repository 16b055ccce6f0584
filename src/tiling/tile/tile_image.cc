// What outlives a tile's triangulation. A sleeping tile as bytes: counts first, then flat arrays. The image is read on
// the machine and by the version that wrote it, so layout and byte order are those of memory. Lengths and ranges are
// checked all the same.
#include <algorithm>

#include "src/base/flat_codec.h"
#include "src/tiling/tile/tile_triangulation.h"

namespace tessera {
namespace {

constexpr std::uint64_t magic = 0x3665676d49454c54u;

struct KnownSeed {
  std::uint64_t vertex;
  double reach;
};

}  // namespace

BigVector<std::byte> TileTriangulation::save() const {
  FlatWriter out;
  KernelImage image = kernel_->save();
  const std::vector<std::uint64_t> sent = sent_.keys();
  out.reserve(image.points.size() * 48 + image.cells.vertices.size() * 8 + sent.size() * 8 + seeds_.size() * 16 +
              open_cells_.size() * 16 + relied_.size() * 8 + refused_relied_.size() * sizeof(RefusedRelied) + 1024);
  out.value(magic);
  out.value(options_.self);
  out.value(static_cast<std::int32_t>(options_.dimension));
  out.value(options_.kernel);
  out.value(static_cast<std::uint8_t>(handed_out_));
  out.value(static_cast<std::uint8_t>(reduced_));
  out.value(counts_);
  out.value(static_cast<std::int32_t>(image.dimension));
  out.last(image.points);
  out.last(image.local);
  out.last(image.alive);
  out.last(image.cells.vertices);
  out.last(image.cells.neighbors);
  out.value(image.frozen);
  out.list(ids_);
  out.list(owners_);
  out.list(told_);
  out.list(ranks_);
  std::vector<KnownSeed> seeds;
  for (const auto& [vertex, reach] : seeds_) seeds.push_back({vertex, reach});
  out.list(seeds);
  out.value(due_);
  out.value(static_cast<std::uint8_t>(seeded_));
  out.list(sent);
  out.list(relied_);
  out.list(refused_relied_);
  out.list(std::vector<CellKey>(open_cells_.begin(), open_cells_.end()));
  return out.take();
}

bool TileTriangulation::load(BigVector<std::byte> bytes) {
  FlatReader in(bytes);
  std::uint64_t found = 0;
  TileId self;
  std::int32_t dimension = 0;
  std::uint8_t handed_out = 0, reduced = 0, seeded = 0;
  KernelKind kernel = KernelKind::flat;
  ExchangeCounts counts;
  KernelImage image;
  std::vector<PointId> ids;
  std::vector<TileId> owners;
  std::vector<std::uint64_t> sent, relied;
  std::vector<RefusedRelied> refused_relied;
  std::vector<std::uint32_t> told, ranks;
  std::vector<KnownSeed> seeds;
  Vertex due = 0;
  std::vector<CellKey> open_cells;
  const bool read = in.value(found) && found == magic && in.value(self) && self == options_.self &&
                    in.value(dimension) && dimension == options_.dimension && in.value(kernel) &&
                    kernel == options_.kernel && in.value(handed_out) && in.value(reduced) && in.value(counts) &&
                    in.value(image.dimension) && in.list(image.points) && in.list(image.local) &&
                    in.list(image.alive) && in.list(image.cells.vertices) && in.list(image.cells.neighbors) &&
                    in.value(image.frozen) && in.list(ids) && in.list(owners) && in.list(told) && in.list(ranks) &&
                    in.list(seeds) && in.value(due) && in.value(seeded) && in.list(sent) && in.list(relied) &&
                    in.list(refused_relied) && in.list(open_cells) && in.at_end();
  if (!read) return false;
  const std::size_t n = image.points.size() + 1;
  if (ids.size() != n || owners.size() != n || told.size() != n || (reduced ? ranks.size() != n : !ranks.empty()))
    return false;
  if (due == 0 || due > n) return false;
  for (const auto& seed : seeds) {
    if (seed.vertex >= n) return false;
  }
  for (const auto* pairs : {&sent, &relied}) {
    if (std::any_of(pairs->begin(), pairs->end(), [&](std::uint64_t pair) { return pair >> 32 >= n; })) return false;
  }
  // A tile wakes up when memory is short, so there are never more than two copies of it.
  BigVector<std::byte>().swap(bytes);
  if (!kernel_->load(image)) return false;
  image = {};
  ids_ = std::move(ids);
  owners_ = std::move(owners);
  told_ = std::move(told);
  ranks_ = std::move(ranks);
  handed_out_ = handed_out != 0;
  reduced_ = reduced != 0;
  counts_ = counts;
  foreign_.clear();
  for (Vertex v = 1; v < n; ++v) {
    if (!is_local(v)) foreign_[ids_[v]] = kernel_->alive(v) ? v : 0;
  }
  seeds_.clear();
  for (const auto& seed : seeds) seeds_[static_cast<Vertex>(seed.vertex)] = seed.reach;
  due_ = due;
  seeded_ = seeded != 0;
  refused_.clear();
  sent_ = {};
  for (const std::uint64_t key : sent)
    sent_.add(static_cast<Vertex>(key >> 32), TileId{static_cast<std::uint32_t>(key)});
  relied_ = std::move(relied);
  refused_relied_ = std::move(refused_relied);
  for (const RefusedRelied& r : refused_relied_) foreign_.insert({r.point.id, 0});  // it stays refused
  open_cells_ = {open_cells.begin(), open_cells.end()};
  updates_.clear();
  return true;
}

std::vector<SharedPoint> TileTriangulation::foreign_vertices() const {
  std::vector<SharedPoint> out;
  for (Vertex v = 1; v < ids_.size(); ++v) {
    if (!is_local(v) && kernel_->alive(v)) out.push_back({kernel_->point(v), ids_[v], owners_[v], 0});
  }
  return out;
}

}  // namespace tessera
