#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "src/geometry/predicates/exact/predicates.h"
#include "src/result/measure/values.h"
#include "src/result/measure/voronoi_cells.h"
#include "src/result/verify/match_facets.h"

namespace tessera {
namespace {

class Voronoi final : public TileMeasure {
 public:
  Voronoi(const TileSource& source, std::stop_token stop) : source_(source), stop_(std::move(stop)) {}

  std::vector<ResultColumn> columns() const override {
    const Manifest& manifest = source_.manifest();
    const int d = manifest.dimension;
    const auto column = [](const char* name, AttributeType type, std::string unit) {
      return ResultColumn{.name = name,
                          .of_cells = false,
                          .type = type,
                          .unit = std::move(unit),
                          .command = {},
                          .software_version = {}};
    };
    std::vector<ResultColumn> made{
        column(d == 2 ? "voronoi_area" : "voronoi_volume", AttributeType::f64, unit_of(manifest, d)),
        column(d == 2 ? "voronoi_boundary" : "voronoi_surface", AttributeType::f64, unit_of(manifest, d - 1)),
        column("voronoi_neighbours", AttributeType::u32, "")};
    for (const char* axis : {"voronoi_x", "voronoi_y", "voronoi_z"})
      if (made.size() < static_cast<std::size_t>(d) + 3)
        made.push_back(column(axis, AttributeType::f64, unit_of(manifest, 1)));
    return made;
  }

  Result<PassValues> of(std::size_t index, const StoredTile& tile) override {
    if (!tile.mesh.neighbors.empty()) return of_mesh(index, tile.mesh);
    TileMesh matched = tile.mesh;  // a result without stored neighbours
    BOOST_OUTCOME_TRYV(match_facets(matched, source_.file(index)));
    return of_mesh(index, matched);
  }

  void finish(std::vector<ResultColumn>& /*columns*/) const override {}
  std::uint64_t infinite() const override { return 0; }  // cells on the hull are unbounded, and not too large

 private:
  // Without this, a damaged cell would give wrong volumes.
  Status check_cells(std::size_t index, const TileMesh& mesh) const {
    const std::size_t corners = static_cast<std::size_t>(mesh.dimension) + 1;
    for (std::size_t cell = 0; cell < mesh.cell_ghost.size(); ++cell) {
      const auto at = [&](std::size_t k) -> const Point& {
        return mesh.points[static_cast<std::size_t>(mesh.cells[cell * corners + k])];
      };
      const int sign = corners == 3 ? exact::orientation_2_staged(at(0), at(1), at(2)).sign
                                    : exact::orientation_3_staged(at(0), at(1), at(2), at(3)).sign;
      if (sign <= 0) return not_oriented(source_, index, cell);
    }
    return success();
  }

  Result<PassValues> of_mesh(std::size_t index, const TileMesh& mesh) const {
    BOOST_OUTCOME_TRYV(check_cells(index, mesh));
    const std::size_t vertices = mesh.points.size();
    std::vector<double> volumes(vertices), surfaces(vertices);
    std::vector<std::uint32_t> neighbours(vertices);
    std::array<std::vector<double>, 3> centroids;
    for (int axis = 0; axis < mesh.dimension; ++axis) centroids[static_cast<std::size_t>(axis)].resize(vertices);
    const auto take = [&](std::size_t v, const voronoi::VoronoiCell& cell) {
      volumes[v] = cell.volume;
      surfaces[v] = cell.surface;
      neighbours[v] = cell.neighbours;
      for (int axis = 0; axis < mesh.dimension; ++axis)
        centroids[static_cast<std::size_t>(axis)][v] = cell.centroid[static_cast<std::size_t>(axis)];
    };
    BOOST_OUTCOME_TRYV(mesh.dimension == 2 ? voronoi::planar_cells(mesh, stop_, take)
                                           : voronoi::space_cells(mesh, stop_, take));
    PassValues bytes{as_bytes(volumes), as_bytes(surfaces), as_bytes(neighbours)};
    for (int axis = 0; axis < mesh.dimension; ++axis)
      bytes.push_back(as_bytes(centroids[static_cast<std::size_t>(axis)]));
    return bytes;
  }

  const TileSource& source_;
  std::stop_token stop_;
};

}  // namespace

std::unique_ptr<TileMeasure> measure_voronoi(const TileSource& source, std::stop_token stop) {
  return std::make_unique<Voronoi>(source, std::move(stop));
}

}  // namespace tessera
