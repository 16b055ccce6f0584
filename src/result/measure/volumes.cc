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
  explicit Volumes(const TileSource& source) : source_(source) {}

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

  std::unique_ptr<CellValues> cells_of(const TileMesh& mesh) override { return std::make_unique<OfTile>(*this, mesh); }

  void finish(std::vector<ResultColumn>& columns) const override {
    columns[0].total = rounded_quotient(sum_.value(), source_.manifest().dimension == 2 ? 2 : 6);
  }
  std::uint64_t infinite() const override { return infinite_; }

 private:
  class OfTile final : public CellValues {
   public:
    OfTile(Volumes& all, const TileMesh& mesh) : all_(all), mesh_(mesh), volumes_(mesh.cell_ghost.size()) {}

    void take(std::size_t cell, std::span<const std::int32_t> /*vertices*/, const ScaledInteger& exact) override {
      volumes_[cell] = rounded_quotient(exact, mesh_.dimension == 2 ? 2 : 6);
      if (mesh_.cell_ghost[cell] != 0) return;
      sum_.add(exact);
      infinite_ += std::isinf(volumes_[cell]) ? 1 : 0;
    }
    PassValues finish() override {
      const auto stars = stars_of(mesh_, volumes_);
      for (const double star : stars) infinite_ += std::isinf(star) ? 1 : 0;
      const std::lock_guard lock(all_.mutex_);
      all_.sum_.add(sum_);
      all_.infinite_ += infinite_;
      return PassValues{as_bytes(volumes_), as_bytes(stars)};
    }

   private:
    Volumes& all_;
    const TileMesh& mesh_;
    std::vector<double> volumes_;
    ExactSum sum_;
    std::uint64_t infinite_ = 0;
  };

  const TileSource& source_;
  std::mutex mutex_;
  ExactSum sum_;
  std::uint64_t infinite_ = 0;
};

}  // namespace

std::unique_ptr<TileMeasure> measure_volumes(const TileSource& source) { return std::make_unique<Volumes>(source); }

}  // namespace tessera
