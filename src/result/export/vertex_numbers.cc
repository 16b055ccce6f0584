#include "src/result/export/vertex_numbers.h"

#include <algorithm>

namespace tessera::exports {

namespace fs = std::filesystem;

namespace {

constexpr std::uint64_t unknown = ~std::uint64_t{0};

// By vertex: 1 when a cell that the filter keeps has the vertex.
std::vector<std::uint8_t> used_here(const TileMesh& mesh, const CellFilter& filter) {
  const std::size_t corners = static_cast<std::size_t>(mesh.dimension) + 1;
  std::vector<std::uint8_t> used(mesh.ids.size(), 0);
  for (std::size_t i = 0; i < mesh.cell_ghost.size(); ++i) {
    if (!filter.keeps(mesh, i)) continue;
    for (std::size_t k = 0; k < corners; ++k) used[static_cast<std::size_t>(mesh.cells[i * corners + k])] = 1;
  }
  return used;
}

PointId image_id(const TileMesh& mesh, std::size_t vertex) {
  return image_of(mesh.ids[vertex], image::offset(mesh.offsets[vertex]));
}

}  // namespace

bool VertexNumbers::is_image(const TileMesh& mesh, std::size_t vertex) const {
  return images_apart_ && !mesh.offsets.empty() && mesh.offsets[vertex] != 0;
}

Result<VertexNumbers> VertexNumbers::prepare(const TileSource& source, const CellFilter& filter, bool images_apart,
                                             std::stop_token stop) {
  VertexNumbers numbers(filter);
  auto& shared = numbers.shared_;
  numbers.images_apart_ = images_apart && source.period().any();
  if (numbers.images_apart_) numbers.images_by_tile_.assign(source.tiles(), 0);
  for (std::size_t index = 0; index < source.tiles(); ++index) {
    if (stop.stop_requested()) return error(Errc::interrupted, "interrupted while exporting");
    BOOST_OUTCOME_TRY(tile, source.read(index, {.cells = numbers.images_apart_}));
    if (numbers.images_apart_) numbers.find_images(tile.mesh, index);
    const auto before = static_cast<std::ptrdiff_t>(shared.size());
    for (std::size_t i = 0; i < tile.mesh.ids.size(); ++i)
      if (tile.mesh.point_ghost[i] != 0 && !numbers.is_image(tile.mesh, i))
        shared.emplace_back(tile.mesh.ids[i], unknown);
    std::sort(shared.begin() + before, shared.end());
    std::inplace_merge(shared.begin(), shared.begin() + before, shared.end());
    shared.erase(std::unique(shared.begin(), shared.end()), shared.end());
  }
  if (filter.active()) {
    numbers.used_.assign(shared.size(), 0);
    numbers.alone_.assign(source.tiles(), 0);
  }
  return numbers;
}

void VertexNumbers::find_images(const TileMesh& mesh, std::size_t index) {
  if (mesh.offsets.empty()) return;
  const auto used = used_here(mesh, filter_);
  const auto before = static_cast<std::ptrdiff_t>(images_.size());
  for (std::size_t i = 0; i < used.size(); ++i)
    if (used[i] != 0 && is_image(mesh, i)) images_.push_back({image_id(mesh, i), index, unknown});
  // The stable merge keeps the entry of the first tile before those of later ones.
  const auto less = [](const Image& a, const Image& b) { return a.id < b.id; };
  std::sort(images_.begin() + before, images_.end(), less);
  std::inplace_merge(images_.begin(), images_.begin() + before, images_.end(), less);
  const auto same = [](const Image& a, const Image& b) { return a.id == b.id; };
  const std::size_t known = static_cast<std::size_t>(before);
  images_.erase(std::unique(images_.begin(), images_.end(), same), images_.end());
  images_by_tile_[index] = images_.size() - known;
}

const VertexNumbers::Image* VertexNumbers::image(const TileMesh& mesh, std::size_t vertex) const {
  const PointId id = image_id(mesh, vertex);
  const auto found =
      std::lower_bound(images_.begin(), images_.end(), id, [](const Image& a, PointId b) { return a.id < b; });
  return found == images_.end() || found->id != id ? nullptr : &*found;
}

std::size_t VertexNumbers::place(PointId id) const {
  const auto found = std::lower_bound(shared_.begin(), shared_.end(), std::pair(id, std::uint64_t{0}));
  if (found == shared_.end() || found->first != id) return shared_.size();
  return static_cast<std::size_t>(found - shared_.begin());
}

void VertexNumbers::survey(const TileMesh& mesh, std::size_t index) {
  const auto used = used_here(mesh, filter_);
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (is_image(mesh, i)) continue;
    const std::size_t at = place(mesh.ids[i]);
    if (at == shared_.size()) {
      alone_[index] += used[i];
      continue;
    }
    used_[at] |= used[i];
    if (mesh.point_ghost[i] == 0) shared_[at].second = index;
  }
}

std::vector<std::uint64_t> VertexNumbers::used_by_tile() const {
  auto counts = alone_;
  for (std::size_t at = 0; at < shared_.size(); ++at)
    if (used_[at] != 0 && shared_[at].second != unknown) ++counts[static_cast<std::size_t>(shared_[at].second)];
  return counts;
}

std::vector<std::uint8_t> VertexNumbers::exported_with(const TileMesh& mesh, std::size_t index) const {
  auto exported = filter_.active() ? used_here(mesh, filter_) : std::vector<std::uint8_t>(mesh.ids.size(), 1);
  for (std::size_t i = 0; i < exported.size(); ++i) {
    if (is_image(mesh, i)) {
      const Image* found = image(mesh, i);
      exported[i] = found != nullptr && found->tile == index ? 1 : 0;
    } else if (mesh.point_ghost[i] != 0) {
      exported[i] = 0;
    } else if (filter_.active() && exported[i] == 0) {
      const std::size_t at = place(mesh.ids[i]);
      exported[i] = at < shared_.size() ? used_[at] : 0;
    }
  }
  return exported;
}

void VertexNumbers::number_own(const TileMesh& mesh, const std::vector<std::uint8_t>& exported) {
  first_.push_back(next_);
  for (std::size_t i = 0; i < mesh.ids.size(); ++i) {
    if (exported[i] == 0) continue;
    if (is_image(mesh, i)) {
      image(mesh, i)->number = next_++;
      continue;
    }
    const std::size_t at = place(mesh.ids[i]);
    if (at < shared_.size()) shared_[at].second = next_;
    ++next_;
  }
}

Result<std::vector<std::uint64_t>> VertexNumbers::of(const TileMesh& mesh, std::size_t index,
                                                     const fs::path& path) const {
  std::vector<std::uint64_t> numbers(mesh.ids.size());
  const auto exported = exported_with(mesh, index);
  std::uint64_t own = first_[index];
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (mesh.point_ghost[i] == 0) {
      numbers[i] = exported[i] != 0 ? own++ : unknown;
      continue;
    }
    if (is_image(mesh, i)) {
      const Image* found = image(mesh, i);
      numbers[i] = found == nullptr ? unknown : found->number;
      continue;
    }
    const std::size_t at = place(mesh.ids[i]);
    if (at == shared_.size() || shared_[at].second == unknown)
      return error(Errc::corrupt,
                   path.string() + ": foreign vertex " + to_string(mesh.ids[i]) + " is not an own vertex of any tile");
    numbers[i] = shared_[at].second;
  }
  return numbers;
}

}  // namespace tessera::exports
