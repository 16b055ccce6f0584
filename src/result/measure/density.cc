#include <atomic>
#include <cmath>
#include <string>
#include <utility>

#include "src/base/option.h"
#include "src/result/measure/star_density.h"
#include "src/result/measure/values.h"

namespace tessera {
namespace {

class Densities final : public TileMeasure {
 public:
  Densities(const TileSource& source, VertexMasses masses, const std::string& attribute, std::stop_token stop)
      : source_(source),
        masses_(std::move(masses)),
        name_(attribute.empty() ? "density" : "density_" + attribute),
        stop_(std::move(stop)) {
    // The unit of an attribute is not known. Without one, densities count points.
    if (attribute.empty()) unit_ = unit_of(source.manifest(), source.manifest().dimension);
    if (!unit_.empty()) unit_ = "1/" + unit_;
  }

  std::vector<ResultColumn> columns() const override {
    return {{.name = name_,
             .of_cells = false,
             .type = AttributeType::f64,
             .unit = unit_,
             .command = {},
             .software_version = {}}};
  }

  Result<PassValues> of(std::size_t index, const StoredTile& tile) override {
    BOOST_OUTCOME_TRY(masses, masses_.of(source_, index, tile.mesh));
    BOOST_OUTCOME_TRY(densities, star_densities(source_, index, tile.mesh, masses, stop_));
    std::vector<double> values(densities.size());
    for (std::size_t v = 0; v < values.size(); ++v) {
      values[v] = densities[v].value();
      infinite_ += std::isinf(values[v]) ? 1 : 0;
    }
    return PassValues{as_bytes(values)};
  }

  void finish(std::vector<ResultColumn>& /*columns*/) const override {}
  std::uint64_t infinite() const override { return infinite_; }
  std::string note() const override { return masses_.note(); }

 private:
  const TileSource& source_;
  VertexMasses masses_;
  std::string name_, unit_;
  std::stop_token stop_;
  std::atomic<std::uint64_t> infinite_ = 0;
};

}  // namespace

Result<std::unique_ptr<TileMeasure>> measure_density(const TileSource& source, const std::string& mass,
                                                     std::uint64_t memory_bytes, std::stop_token stop) {
  BOOST_OUTCOME_TRY(masses, VertexMasses::open(source, mass, memory_bytes));
  return measure_density(source, std::move(masses), mass, std::move(stop));
}

std::unique_ptr<TileMeasure> measure_density(const TileSource& source, VertexMasses masses, const std::string& mass,
                                             std::stop_token stop) {
  return std::make_unique<Densities>(source, std::move(masses), mass, std::move(stop));
}

}  // namespace tessera
