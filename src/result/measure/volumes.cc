#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <numeric>
#include <span>
#include <string>
#include <utility>

#include "src/geometry/mesh/tile_mesh.h"
#include "src/result/measure/exact_volume.h"
#include "src/result/measure/values.h"

namespace tessera {
namespace {

// For own vertices, the sum over the cells around, from the least value to the greatest, so that the order of the cells
// does not matter. Zero for other vertices.
std::vector<double> stars_of(const TileMesh& mesh, const std::vector<double>& volumes) {
  const Stars around(mesh);
  std::vector<double> stars(mesh.points.size(), 0), values;
  for (std::size_t v = 0; v < stars.size(); ++v) {
    values.clear();
    for (const std::uint32_t cell : around.of(v)) values.push_back(volumes[cell]);
    std::sort(values.begin(), values.end());
    stars[v] = std::accumulate(values.begin(), values.end(), 0.0);
  }
  return stars;
}

class Volumes final : public TileMeasure {
 public:
  Volumes(const TileSource& source, std::stop_token stop) : source_(source), stop_(std::move(stop)) {}

  std::vector<ResultColumn> columns() const override {
    const Manifest& manifest = source_.manifest();
    const std::string name = manifest.dimension == 2 ? "area" : "volume";
    ResultColumn column{.name = name,
                        .of_cells = true,
                        .type = AttributeType::f64,
                        .unit = unit_of(manifest, manifest.dimension),
                        .command = {},
                        .software_version = {}};
    std::vector<ResultColumn> both{column};
    column.name = "star_" + name;
    column.of_cells = false;
    both.push_back(std::move(column));
    return both;
  }

  Result<PassValues> of(std::size_t index, const StoredTile& tile) override {
    const TileMesh& mesh = tile.mesh;
    const unsigned factorial = mesh.dimension == 2 ? 2 : 6;
    std::vector<double> volumes(mesh.cell_ghost.size());
    ExactSum sum;
    std::uint64_t infinite = 0;
    BOOST_OUTCOME_TRYV(for_each_cell(source_, index, mesh, stop_,
                                     [&](std::size_t cell, std::span<const std::int32_t>, const ScaledInteger& exact) {
                                       volumes[cell] = rounded_quotient(exact, factorial);
                                       if (mesh.cell_ghost[cell] != 0) return;
                                       sum.add(exact);
                                       infinite += std::isinf(volumes[cell]) ? 1 : 0;
                                     }));
    const auto stars = stars_of(mesh, volumes);
    for (const double star : stars) infinite += std::isinf(star) ? 1 : 0;
    const std::lock_guard lock(mutex_);
    sum_.add(sum);
    infinite_ += infinite;
    return PassValues{as_bytes(volumes), as_bytes(stars)};
  }

  void finish(std::vector<ResultColumn>& columns) const override {
    columns[0].total = rounded_quotient(sum_.value(), source_.manifest().dimension == 2 ? 2 : 6);
  }
  std::uint64_t infinite() const override { return infinite_; }

 private:
  const TileSource& source_;
  std::stop_token stop_;
  std::mutex mutex_;
  ExactSum sum_;
  std::uint64_t infinite_ = 0;
};

}  // namespace

std::unique_ptr<TileMeasure> measure_volumes(const TileSource& source, std::stop_token stop) {
  return std::make_unique<Volumes>(source, std::move(stop));
}

}  // namespace tessera
