#include "src/export/vertex_numbers.h"

#include <algorithm>

namespace tessera::exports {

namespace fs = std::filesystem;

namespace {

constexpr std::uint64_t unknown = ~std::uint64_t{0};

}  // namespace

Result<VertexNumbers> VertexNumbers::prepare(const fs::path& out, const Manifest& manifest, std::stop_token stop) {
  VertexNumbers numbers;
  auto& foreign = numbers.foreign_;
  for (const auto& entry : manifest.tiles) {
    if (stop.stop_requested()) return error(Errc::interrupted, "interrupted while exporting");
    BOOST_OUTCOME_TRY(tile, read_tile_vertices(out, entry.tile));
    const auto before = static_cast<std::ptrdiff_t>(foreign.size());
    for (std::size_t i = 0; i < tile.mesh.ids.size(); ++i)
      if (tile.mesh.point_ghost[i] != 0) foreign.emplace_back(tile.mesh.ids[i], unknown);
    std::sort(foreign.begin() + before, foreign.end());
    std::inplace_merge(foreign.begin(), foreign.begin() + before, foreign.end());
    foreign.erase(std::unique(foreign.begin(), foreign.end()), foreign.end());
  }
  return numbers;
}

void VertexNumbers::number_own(const TileMesh& mesh) {
  first_.push_back(next_);
  for (std::size_t i = 0; i < mesh.ids.size(); ++i) {
    if (mesh.point_ghost[i] != 0) continue;
    const auto found = std::lower_bound(foreign_.begin(), foreign_.end(), std::pair(mesh.ids[i], std::uint64_t{0}));
    if (found != foreign_.end() && found->first == mesh.ids[i]) found->second = next_;
    ++next_;
  }
}

Result<std::vector<std::uint64_t>> VertexNumbers::of(const TileMesh& mesh, std::size_t index,
                                                     const fs::path& path) const {
  std::vector<std::uint64_t> numbers(mesh.ids.size());
  std::uint64_t own = first_[index];
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (mesh.point_ghost[i] == 0) {
      numbers[i] = own++;
      continue;
    }
    const auto found = std::lower_bound(foreign_.begin(), foreign_.end(), std::pair(mesh.ids[i], std::uint64_t{0}));
    if (found == foreign_.end() || found->first != mesh.ids[i] || found->second == unknown)
      return error(Errc::corrupt,
                   path.string() + ": foreign vertex " + to_string(mesh.ids[i]) + " is no tile's own vertex");
    numbers[i] = found->second;
  }
  return numbers;
}

}  // namespace tessera::exports
