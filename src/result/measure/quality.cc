#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <string>
#include <utility>

#include "src/geometry/mesh/image_order.h"
#include "src/result/measure/cell_quality.h"
#include "src/result/measure/values.h"

namespace tessera {
namespace {

class Quality final : public TileMeasure {
 public:
  explicit Quality(const TileSource& source) : source_(source) {}

  std::vector<ResultColumn> columns() const override {
    std::vector<ResultColumn> made;
    const std::string length = unit_of(source_.manifest(), 1);
    for (const auto& [name, unit] : {std::pair<const char*, std::string>("radius_ratio", ""),
                                     {"least_angle", "degree"},
                                     {"largest_angle", "degree"},
                                     {"circumradius", length}})
      made.push_back({.name = name,
                      .of_cells = true,
                      .type = AttributeType::f64,
                      .unit = unit,
                      .command = {},
                      .software_version = {}});
    return made;
  }

  std::unique_ptr<CellValues> cells_of(const TileMesh& mesh) override { return std::make_unique<OfTile>(*this, mesh); }

  void finish(std::vector<ResultColumn>& /*columns*/) const override {}
  std::uint64_t infinite() const override { return infinite_; }

 private:
  class OfTile final : public CellValues {
   public:
    OfTile(Quality& all, const TileMesh& mesh) : all_(all), mesh_(mesh) {
      for (auto& each : values_) each.resize(mesh.cell_ghost.size());
    }

    void take(std::size_t cell, std::span<const std::int32_t> vertices, const ScaledInteger& exact) override {
      const CellQuality quality = quality_of_cell(mesh_, vertices, exact);
      values_[0][cell] = quality.radius_ratio;
      values_[1][cell] = quality.least_angle;
      values_[2][cell] = quality.largest_angle;
      values_[3][cell] = quality.circumradius;
      infinite_ += mesh_.cell_ghost[cell] == 0 && std::isinf(quality.circumradius) ? 1 : 0;
    }
    PassValues finish() override {
      all_.infinite_ += infinite_;
      PassValues bytes;
      for (const auto& each : values_) bytes.push_back(as_bytes(each));
      return bytes;
    }

   private:
    Quality& all_;
    const TileMesh& mesh_;
    std::array<std::vector<double>, 4> values_;
    std::uint64_t infinite_ = 0;
  };

  // By the vertices in their order, so that a cell has the same bits in all tiles.
  static CellQuality quality_of_cell(const TileMesh& mesh, std::span<const std::int32_t> vertices,
                                     const ScaledInteger& exact) {
    std::array<std::int32_t, 4> sorted{};
    std::copy(vertices.begin(), vertices.end(), sorted.begin());
    const auto end = sorted.begin() + static_cast<std::ptrdiff_t>(vertices.size());
    std::sort(sorted.begin(), end, [&](std::int32_t a, std::int32_t b) {
      return image_order(mesh, static_cast<std::size_t>(a)) < image_order(mesh, static_cast<std::size_t>(b));
    });
    std::array<Point, 4> corners;
    for (std::size_t k = 0; k < vertices.size(); ++k) {
      corners[k] = mesh.points[static_cast<std::size_t>(sorted[k])];
      if (mesh.dimension == 2) corners[k].z = 0;
    }
    return quality_of(std::span(corners).first(vertices.size()), exact);
  }

  const TileSource& source_;
  std::atomic<std::uint64_t> infinite_ = 0;
};

}  // namespace

std::unique_ptr<TileMeasure> measure_quality(const TileSource& source) { return std::make_unique<Quality>(source); }

}  // namespace tessera
