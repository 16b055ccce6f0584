#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <string>
#include <utility>

#include "src/result/measure/cell_quality.h"
#include "src/result/measure/values.h"

namespace tessera {
namespace {

class Quality final : public TileMeasure {
 public:
  Quality(const TileSource& source, std::stop_token stop) : source_(source), stop_(std::move(stop)) {}

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

  Result<PassValues> of(std::size_t index, const StoredTile& tile) override {
    const TileMesh& mesh = tile.mesh;
    std::array<std::vector<double>, 4> values;
    for (auto& each : values) each.resize(mesh.cell_ghost.size());
    std::uint64_t infinite = 0;
    BOOST_OUTCOME_TRYV(
        for_each_cell(source_, index, mesh, stop_,
                      [&](std::size_t cell, std::span<const std::int32_t> vertices, const ScaledInteger& exact) {
                        const CellQuality quality = quality_of_cell(mesh, vertices, exact);
                        values[0][cell] = quality.radius_ratio;
                        values[1][cell] = quality.least_angle;
                        values[2][cell] = quality.largest_angle;
                        values[3][cell] = quality.circumradius;
                        infinite += mesh.cell_ghost[cell] == 0 && std::isinf(quality.circumradius) ? 1 : 0;
                      }));
    infinite_ += infinite;
    PassValues bytes;
    for (const auto& each : values) bytes.push_back(as_bytes(each));
    return bytes;
  }

  void finish(std::vector<ResultColumn>& /*columns*/) const override {}
  std::uint64_t infinite() const override { return infinite_; }

 private:
  // By the vertices in the order of their ids, so that a cell has the same bits in all tiles.
  static CellQuality quality_of_cell(const TileMesh& mesh, std::span<const std::int32_t> vertices,
                                     const ScaledInteger& exact) {
    std::array<std::int32_t, 4> sorted{};
    std::copy(vertices.begin(), vertices.end(), sorted.begin());
    const auto end = sorted.begin() + static_cast<std::ptrdiff_t>(vertices.size());
    std::sort(sorted.begin(), end, [&](std::int32_t a, std::int32_t b) {
      return mesh.ids[static_cast<std::size_t>(a)] < mesh.ids[static_cast<std::size_t>(b)];
    });
    std::array<Point, 4> corners;
    for (std::size_t k = 0; k < vertices.size(); ++k) {
      corners[k] = mesh.points[static_cast<std::size_t>(sorted[k])];
      if (mesh.dimension == 2) corners[k].z = 0;
    }
    return quality_of(std::span(corners).first(vertices.size()), exact);
  }

  const TileSource& source_;
  std::stop_token stop_;
  std::atomic<std::uint64_t> infinite_ = 0;
};

}  // namespace

std::unique_ptr<TileMeasure> measure_quality(const TileSource& source, std::stop_token stop) {
  return std::make_unique<Quality>(source, std::move(stop));
}

}  // namespace tessera
