// Computes the columns of a result again after its points have changed. A measure of a cell depends on the cell alone,
// and a measure of a vertex on the cells around it. So values of tiles whose cells stay are what they were, but for
// densities: these depend on the mass of the vertex, too, which is the number of points at its place, or the value of
// an attribute or of another column.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "src/base/result.h"
#include "src/result/measure/tile_measure.h"
#include "src/result/pass.h"
#include "src/result/store/tile_store.h"
#include "src/result/tile_source.h"

namespace tessera {

// Error usage when the result has a column that nothing here makes. `result`: for the error.
Status check_can_be_made_again(const std::filesystem::path& result, const Manifest& manifest);

// Whether the values are densities of masses, which are an attribute or another column: a mass may be none.
bool depends_on_masses(const ResultColumn& column);
// Whether the values change with the duplicates of a vertex.
bool depends_on_duplicates(const ResultColumn& column);

class ColumnsAgain {
 public:
  struct Wanted {
    std::filesystem::path result;  // for errors
    const std::vector<ResultColumn>& columns;
    std::span<const DuplicatePair> duplicates;  // as they are after the change
  };
  // For tiles of `source`, which has no columns and must outlive the object. Errors: usage when nothing makes one of
  // the columns.
  static Result<ColumnsAgain> of(const TileSource& source, const Wanted& wanted, const std::stop_token& stop);
  // The values of a tile in the order of the columns: of all cells, and of the own vertices. Safe to call from several
  // threads for different tiles. Errors: those of TileMeasure::of(); bad_input for a mass that is not finite.
  Result<PassValues> values(std::size_t index, const StoredTile& tile);

 private:
  // Where the values of a column come from: from a measure, or from another column, whose values are the masses.
  struct Origin {
    std::size_t place = 0;  // among the columns of the measures
    std::optional<std::size_t> mass = {};
  };
  ColumnsAgain(const TileSource& source, const Wanted& wanted, std::stop_token stop)
      : source_(source), result_(wanted.result.string()), columns_(wanted.columns), stop_(std::move(stop)) {}
  void add(std::unique_ptr<TileMeasure> measure);
  Status add_densities(const Wanted& wanted);
  Result<Origin> origin_of(const ResultColumn& column) const;
  Result<std::vector<std::byte>> densities(std::size_t index, const TileMesh& mesh, std::size_t mass,
                                           const PassValues& made) const;

  const TileSource& source_;
  std::string result_;
  std::vector<ResultColumn> columns_;
  std::stop_token stop_;
  std::vector<std::unique_ptr<TileMeasure>> measures_;
  std::vector<ResultColumn> made_;  // the columns of the measures
  std::vector<Origin> origins_;     // by column
};

}  // namespace tessera
