#include "src/result/measure/star_density.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string>
#include <utility>

#include "src/base/option.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "src/result/measure/order_free_sum.h"
#include "src/result/measure/values.h"
#include "src/result/query/column.h"
#include "src/result/store/tile_store.h"

namespace tessera {

Result<VertexMasses> VertexMasses::open(const TileSource& source, const std::string& attribute,
                                        std::uint64_t memory_bytes) {
  const Manifest& manifest = source.manifest();
  if (!attribute.empty()) {
    VertexMasses masses;
    masses.result_ = source.folder().string();
    masses.attribute_ = attribute;
    BOOST_OUTCOME_TRY(column, query::find_column(source.folder(), manifest, attribute));
    masses.column_ = column;
    masses.row_bytes_ = row_bytes(manifest.schema);
    masses.left_out_ = manifest.duplicates;
    return masses;
  }
  if (manifest.duplicates == 0) return VertexMasses();
  if (manifest.duplicates > memory_bytes / (2 * sizeof(DuplicatePair)))
    return error(Errc::memory, source.folder().string() + ": its " + std::to_string(manifest.duplicates) +
                                   " duplicates do not fit into the memory; " + option("memory") + " must be larger");
  BOOST_OUTCOME_TRY(pairs, source.read_duplicates());
  return counted(pairs);
}

VertexMasses VertexMasses::counted(std::span<const DuplicatePair> duplicates) {
  std::vector<PointId> kept;
  kept.reserve(duplicates.size());
  for (const DuplicatePair& pair : duplicates) kept.push_back(pair.kept);
  std::sort(kept.begin(), kept.end());
  VertexMasses masses;
  for (const PointId vertex : kept) {
    if (masses.shared_.empty() || masses.shared_.back().vertex != vertex) masses.shared_.push_back({vertex, 0});
    ++masses.shared_.back().duplicates;
  }
  return masses;
}

Error mass_not_finite(const std::string& result, const std::string& name, PointId vertex, double mass) {
  return error(Errc::bad_input, result + ": the attribute '" + name + "' of vertex " + to_string(vertex) + " is " +
                                    std::to_string(mass) + ", but a mass must be finite");
}

Result<std::vector<double>> VertexMasses::of(const TileSource& source, std::size_t index, const TileMesh& mesh) const {
  std::vector<double> masses(mesh.points.size(), 0);
  if (!column_) {
    for (std::size_t v = 0; v < masses.size(); ++v) {
      if (mesh.point_ghost[v] != 0) continue;
      const auto found = std::lower_bound(shared_.begin(), shared_.end(), mesh.ids[v],
                                          [](const Shared& shared, PointId vertex) { return shared.vertex < vertex; });
      const bool is_shared = found != shared_.end() && found->vertex == mesh.ids[v];
      masses[v] = is_shared ? 1 + static_cast<double>(found->duplicates) : 1;
    }
    return masses;
  }
  BOOST_OUTCOME_TRY(tile, source.read(index, {.cells = false, .rows = true}));
  for (std::size_t v = 0; v < masses.size(); ++v) {
    if (mesh.point_ghost[v] != 0) continue;
    masses[v] = column_->value(tile.rows.data() + v * row_bytes_);
    if (!std::isfinite(masses[v])) return mass_not_finite(result_, attribute_, mesh.ids[v], masses[v]);
  }
  return masses;
}

std::string VertexMasses::note() const {
  if (left_out_ == 0) return "";
  return "the " + std::to_string(left_out_) +
         " duplicates have no part in the masses, because a result holds only the attributes of its vertices";
}

Result<std::vector<ScaledDouble>> star_densities(const TileSource& source, std::size_t index, const TileMesh& mesh,
                                                 std::span<const double> masses, const std::stop_token& stop) {
  const unsigned factorial = mesh.dimension == 2 ? 2 : 6;
  std::vector<OrderFreeSum> stars(mesh.points.size());
  BOOST_OUTCOME_TRYV(for_each_cell(
      source, index, mesh, stop, [&](std::size_t, std::span<const std::int32_t> vertices, const ScaledInteger& exact) {
        const ScaledDouble volume = scaled_quotient(exact, factorial);
        for (const std::int32_t v : vertices) stars[static_cast<std::size_t>(v)].add(volume);
      }));
  std::vector<ScaledDouble> densities(stars.size());
  for (std::size_t v = 0; v < stars.size(); ++v) {
    if (mesh.point_ghost[v] != 0 || masses[v] == 0) continue;
    const ScaledDouble star = stars[v].value();
    if (star.fraction == 0)
      return error(Errc::corrupt, source.file(index).string() + ": vertex " + to_string(mesh.ids[v]) + " has no cell");
    densities[v] = ScaledDouble::of(mesh.dimension + 1) * ScaledDouble::of(masses[v]) / star;
  }
  return densities;
}

}  // namespace tessera
