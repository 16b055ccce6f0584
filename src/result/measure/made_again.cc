#include "src/result/measure/made_again.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "src/base/attribute_value.h"
#include "src/result/measure/star_density.h"
#include "src/result/measure/values.h"

namespace tessera {

namespace {

constexpr std::string_view density_name = "density", of_mass = "density_";

bool is_density(const ResultColumn& column) {
  return !column.of_cells && (column.name == density_name || column.name.starts_with(of_mass));
}

// The attribute or column that has the masses of a density; empty when each point has the mass 1. REQUIRES:
// is_density().
std::string mass_of(const ResultColumn& column) {
  return column.name == density_name ? std::string() : column.name.substr(of_mass.size());
}

bool is_same(const ResultColumn& a, const ResultColumn& b) {
  return a.name == b.name && a.of_cells == b.of_cells && a.type == b.type;
}

std::optional<std::size_t> place_in(const std::vector<ResultColumn>& columns, const ResultColumn& wanted) {
  const auto found = std::ranges::find_if(columns, [&](const ResultColumn& one) { return is_same(one, wanted); });
  if (found == columns.end()) return std::nullopt;
  return static_cast<std::size_t>(found - columns.begin());
}

}  // namespace

Status check_can_be_made_again(const std::filesystem::path& result, const Manifest& manifest) {
  if (manifest.columns.empty()) return success();
  const TileSource source = TileSource::draft(result, without_columns(manifest));
  BOOST_OUTCOME_TRYV(ColumnsAgain::of(source, {result, manifest.columns, {}}, {}));
  return success();
}

bool depends_on_masses(const ResultColumn& column) { return is_density(column) && !mass_of(column).empty(); }

bool depends_on_duplicates(const ResultColumn& column) { return is_density(column) && mass_of(column).empty(); }

void ColumnsAgain::add(std::unique_ptr<TileMeasure> measure) {
  const auto own = measure->columns();
  const bool wanted =
      std::ranges::any_of(own, [&](const ResultColumn& one) { return place_in(columns_, one).has_value(); });
  if (!wanted) return;
  made_.insert(made_.end(), own.begin(), own.end());
  measures_.push_back(std::move(measure));
}

// Those whose masses are counted or are attributes.
Status ColumnsAgain::add_densities(const Wanted& wanted) {
  const TileSource named = TileSource::draft(wanted.result, source_.manifest());
  for (const ResultColumn& column : columns_) {
    if (!is_density(column)) continue;
    const std::string mass = mass_of(column);
    if (mass.empty()) {
      add(measure_density(source_, VertexMasses::counted(wanted.duplicates), mass, stop_));
    } else if (std::ranges::none_of(columns_, [&](const auto& one) { return !one.of_cells && one.name == mass; })) {
      BOOST_OUTCOME_TRY(masses, VertexMasses::open(named, mass, 0));
      add(measure_density(source_, std::move(masses), mass, stop_));
    }
  }
  return success();
}

// A column whose masses are another one came later than that.
Result<ColumnsAgain::Origin> ColumnsAgain::origin_of(const ResultColumn& column) const {
  if (const auto place = place_in(made_, column)) return Origin{*place};
  if (is_density(column) && column.type == AttributeType::f64) {
    const auto before = std::span(columns_).first(origins_.size());
    const auto mass = std::ranges::find_if(
        before, [&](const ResultColumn& one) { return !one.of_cells && one.name == mass_of(column); });
    if (mass != before.end()) return Origin{0, static_cast<std::size_t>(mass - before.begin())};
  }
  return error(Errc::usage, result_ + ": has the computed column '" + column.name +
                                "', which this program does not know how to compute for other points; change the "
                                "result as it was before this column was computed");
}

Result<ColumnsAgain> ColumnsAgain::of(const TileSource& source, const Wanted& wanted, const std::stop_token& stop) {
  ColumnsAgain again(source, wanted, stop);
  again.add(measure_volumes(source));
  again.add(measure_quality(source));
  again.add(measure_voronoi(source, stop));
  BOOST_OUTCOME_TRYV(again.add_densities(wanted));
  for (const ResultColumn& column : again.columns_) {
    BOOST_OUTCOME_TRY(origin, again.origin_of(column));
    again.origins_.push_back(origin);
  }
  return again;
}

Result<std::vector<std::byte>> ColumnsAgain::densities(std::size_t index, const TileMesh& mesh, std::size_t mass,
                                                       const PassValues& made) const {
  const ResultColumn& column = columns_[mass];
  std::vector<double> masses(mesh.ids.size(), 0);
  for (std::size_t v = 0; v < masses.size(); ++v) {
    if (mesh.point_ghost[v] != 0) continue;
    masses[v] = as_double(column.type, &made[mass][v * size_of(column.type)]);
    if (!std::isfinite(masses[v])) return mass_not_finite(result_, column.name, mesh.ids[v], masses[v]);
  }
  BOOST_OUTCOME_TRY(densities, star_densities(source_, index, mesh, masses, stop_));
  std::vector<double> values;
  values.reserve(densities.size());
  for (const ScaledDouble& density : densities) values.push_back(density.value());
  return as_bytes(values);
}

Result<PassValues> ColumnsAgain::values(std::size_t index, const StoredTile& tile) {
  BOOST_OUTCOME_TRY(made, values_of(measures_, source_, index, tile, stop_));
  PassValues ordered;
  for (const Origin& origin : origins_) {
    if (origin.mass) {
      BOOST_OUTCOME_TRY(values, densities(index, tile.mesh, *origin.mass, ordered));
      ordered.push_back(std::move(values));
    } else {
      ordered.push_back(std::move(made[origin.place]));
    }
  }
  return ordered;
}

}  // namespace tessera
