#include "src/delaunay/run/kept_columns.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <utility>

#include "src/base/files/temporary.h"
#include "src/base/files/whole_file.h"
#include "src/result/store/points_file.h"
#include "src/result/store/tile_columns.h"

namespace tessera {

KeptColumns::KeptColumns(PointsTile& tile, const std::vector<ResultColumn>& columns) {
  const auto of_vertices = std::count_if(columns.begin(), columns.end(), [](const auto& c) { return !c.of_cells; });
  const std::size_t stride = row_bytes(tile.schema), n = tile.ids.size();
  // columns of vertices are the last attributes
  tile.schema.resize(tile.schema.size() - static_cast<std::size_t>(of_vertices));
  const std::size_t width = row_bytes(tile.schema);
  const auto foreign = by_id(std::span(tile.ids).subspan(tile.own));
  std::size_t offset = width, of_cells = 0;
  for (const ResultColumn& column : columns) {
    Values& to = columns_.emplace_back(Values{column.of_cells, {column.name, column.type}, {}});
    if (column.of_cells) {
      to.values = std::move(tile.cell_columns[of_cells++]);
      continue;
    }
    const std::size_t size = size_of(column.type);
    to.values.resize(n * size);
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t from = i < tile.own ? i : tile.own + foreign[i - tile.own];
      std::memcpy(&to.values[i * size], &tile.rows[from * stride + offset], size);
    }
    offset += size;
  }
  tile.cell_columns.clear();
  tile.cell_schema.clear();
  if (width == stride) return;
  for (std::size_t i = 0; i < n; ++i) std::memmove(tile.rows.data() + i * width, &tile.rows[i * stride], width);
  tile.rows.resize(n * width);
}

Status KeptColumns::put_into(const std::filesystem::path& file, TileEntry& entry, const std::stop_token& stop) const {
  if (columns_.empty()) return success();
  std::vector<store::ColumnValues> columns;
  for (const Values& column : columns_) columns.push_back({column.of_cells, column.as, column.values});
  TemporaryFile temporary(temporary_name_of_process(file));
  const store::TileCopy copy{
      .tile = entry.tile, .from = file, .to = temporary.path(), .final_name = file, .canonical = true};
  BOOST_OUTCOME_TRY(written, store::copy_with_columns(copy, columns, stop));
  BOOST_OUTCOME_TRYV(rename_file(temporary.path(), file));
  temporary.keep();
  entry.bytes = written.bytes;
  entry.xxh3 = written.xxh3;
  return success();
}

}  // namespace tessera
