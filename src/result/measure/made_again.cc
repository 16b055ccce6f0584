#include "src/result/measure/made_again.h"

#include <algorithm>
#include <string>

namespace tessera {

bool can_be_made_again(const ResultColumn& column) {
  return column.name != "density" && !column.name.starts_with("density_");
}

Result<ColumnsAgain> ColumnsAgain::of(const TileSource& source, const std::vector<ResultColumn>& columns,
                                      const std::stop_token& stop) {
  ColumnsAgain again(source, stop);
  std::vector<std::unique_ptr<TileMeasure>> all;
  all.push_back(measure_volumes(source));
  all.push_back(measure_quality(source));
  all.push_back(measure_voronoi(source, stop));
  std::vector<ResultColumn> made;
  for (auto& measure : all) {
    const auto own = measure->columns();
    const bool wanted = std::any_of(own.begin(), own.end(), [&](const ResultColumn& one) {
      return std::any_of(columns.begin(), columns.end(), [&](const ResultColumn& other) {
        return other.name == one.name && other.of_cells == one.of_cells;
      });
    });
    if (!wanted) continue;
    made.insert(made.end(), own.begin(), own.end());
    again.measures_.push_back(std::move(measure));
  }
  for (const ResultColumn& column : columns) {
    const auto found = std::find_if(made.begin(), made.end(), [&](const ResultColumn& one) {
      return one.name == column.name && one.of_cells == column.of_cells && one.type == column.type;
    });
    if (found == made.end()) return error(Errc::internal, "nothing makes the column '" + column.name + "'");
    again.places_.push_back(static_cast<std::size_t>(found - made.begin()));
  }
  return again;
}

Result<PassValues> ColumnsAgain::values(std::size_t index, const StoredTile& tile) {
  BOOST_OUTCOME_TRY(made, values_of(measures_, source_, index, tile, stop_));
  PassValues ordered;
  for (const std::size_t place : places_) ordered.push_back(made[place]);
  return ordered;
}

}  // namespace tessera
