#include "src/result/verify/match_facets.h"

#include <algorithm>
#include <array>
#include <vector>

#include "src/result/verify/cell_ref.h"

namespace tessera {

Status match_facets(TileMesh& mesh, const std::filesystem::path& file, const std::stop_token& stop) {
  constexpr std::size_t steps_a_look = 1 << 18;
  const auto go_on = [&](std::size_t step) { return step % steps_a_look != 0 || !stop.stop_requested(); };
  const auto interrupted = [] { return error(Errc::interrupted, "interrupted while looking for neighbours"); };
  const auto corners = static_cast<std::size_t>(mesh.dimension) + 1;
  const std::size_t facets = mesh.cells.size();
  // The vertices of a facet, sorted; unused entries are -1. Facet `f` is that of cell f / corners opposite corner f %
  // corners.
  const auto key_of = [&](std::size_t facet) {
    std::array<std::int32_t, 3> key{-1, -1, -1};
    const std::size_t cell = facet / corners;
    std::size_t n = 0;
    for (std::size_t k = 0; k < corners; ++k)
      if (k != facet % corners) key[n++] = mesh.cells[cell * corners + k];
    std::sort(key.begin(), key.begin() + static_cast<std::ptrdiff_t>(n));
    return key;
  };
  // A counting sort puts facets into buckets by their least vertex. A bucket is small, and is sorted by key.
  std::vector<std::uint32_t> first(mesh.points.size() + 1, 0), order(facets);
  for (std::size_t f = 0; f < facets; ++f) {
    if (!go_on(f)) return interrupted();
    ++first[static_cast<std::size_t>(key_of(f)[0]) + 1];
  }
  for (std::size_t v = 1; v < first.size(); ++v) first[v] += first[v - 1];
  {
    std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
    for (std::size_t f = 0; f < facets; ++f) {
      if (!go_on(f)) return interrupted();
      order[next[static_cast<std::size_t>(key_of(f)[0])]++] = static_cast<std::uint32_t>(f);
    }
  }

  mesh.neighbors.assign(facets, -2);
  std::vector<std::pair<std::array<std::int32_t, 3>, std::uint32_t>> bucket;
  for (std::size_t v = 0; v + 1 < first.size(); ++v) {
    if (!go_on(v)) return interrupted();
    bucket.clear();
    for (std::uint32_t i = first[v]; i < first[v + 1]; ++i) bucket.emplace_back(key_of(order[i]), order[i]);
    std::sort(bucket.begin(), bucket.end());
    for (std::size_t i = 0; i < bucket.size();) {
      std::size_t end = i + 1;
      while (end < bucket.size() && bucket[end].first == bucket[i].first) ++end;
      const auto cell_of = [&](std::size_t at) { return static_cast<std::int32_t>(bucket[at].second / corners); };
      if (end - i > 2) {
        IdSet ids{padding_id, padding_id, padding_id, padding_id};
        for (std::size_t k = 0; k + 1 < corners; ++k) ids[k] = mesh.ids[static_cast<std::size_t>(bucket[i].first[k])];
        std::sort(ids.begin(), ids.end());
        return error(Errc::not_delaunay, file.string() + ": cells " + std::to_string(cell_of(i)) + ", " +
                                             std::to_string(cell_of(i + 1)) + " and " + std::to_string(cell_of(i + 2)) +
                                             " share the facet of vertices " + text_of(ids));
      }
      if (end - i == 2) {
        mesh.neighbors[bucket[i].second] = cell_of(i + 1);
        mesh.neighbors[bucket[i + 1].second] = cell_of(i);
      } else {
        for (std::size_t k = 0; k + 1 < corners; ++k)
          if (mesh.point_ghost[static_cast<std::size_t>(bucket[i].first[k])] == 0)
            mesh.neighbors[bucket[i].second] = -1;
      }
      i = end;
    }
  }
  return success();
}

}  // namespace tessera
