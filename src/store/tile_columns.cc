#include "src/store/tile_columns.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "src/files/checksum.h"
#include "src/files/names.h"
#include "src/store/packed_array.h"
#include "src/store/packed_tile.h"

namespace tessera::store {

namespace {

// The arrays of the new file.
struct Plan {
  TileHeader header;
  std::vector<std::size_t> order;       // of the old arrays, as they stand in the file
  std::vector<std::size_t> new_places;  // of the columns, in the new header
};

// Old arrays stand where they stood, without gaps; columns behind them.
Result<Plan> plan(const PackedTile& old, std::span<const ColumnValues> columns,
                  const std::vector<PackedArray>& packed) {
  Plan plan{.header = old.header(), .order = {}, .new_places = {}};
  TileHeader& header = plan.header;
  const std::size_t old_arrays = old.arrays().size(), vertices_end = first_attribute + header.schema.size();
  header.format = changed_format;
  for (const auto& column : columns) (column.of_cells ? header.cell_schema : header.schema).push_back(column.as);
  const auto infos = header.arrays();
  const std::size_t of_vertices = first_attribute + header.schema.size() - vertices_end;
  std::size_t next_vertices = vertices_end, next_cells = old_arrays + of_vertices;
  for (const auto& column : columns) {
    plan.new_places.push_back(column.of_cells ? next_cells++ : next_vertices++);
    if (header.bytes_of(infos[plan.new_places.back()]) != column.values.size())
      return error(Errc::internal, "a column has not one value for each row");
  }
  plan.order.resize(old_arrays);
  std::iota(plan.order.begin(), plan.order.end(), std::size_t{0});
  std::ranges::sort(plan.order, {}, [&](std::size_t i) { return old.arrays()[i].table; });
  header.offsets.assign(infos.size(), 0);
  std::uint64_t at = 0;
  for (const std::size_t i : plan.order) {
    header.offsets[i < vertices_end ? i : i + of_vertices] = at;
    at += old.arrays()[i].end - old.arrays()[i].table;
  }
  for (std::size_t k = 0; k < columns.size(); ++k) {
    header.offsets[plan.new_places[k]] = at;
    at += packed[k].file_bytes();
  }
  return plan;
}

Status copy_raw(const PackedTile& old, const PackedTile::Packed& array, std::vector<std::byte>& buffer,
                DirectWriter& file) {
  const std::uint64_t bytes = array.end - array.table;
  for (std::uint64_t done = 0; done < bytes; done += buffer.size()) {
    const auto piece = std::span(buffer).first(std::min<std::uint64_t>(buffer.size(), bytes - done));
    BOOST_OUTCOME_TRYV(old.read_raw(array, done, piece));
    BOOST_OUTCOME_TRYV(file.append(piece));
  }
  return success();
}

}  // namespace

Result<DirectWriter::Written> copy_with_columns(const TileCopy& copy, std::span<const ColumnValues> columns,
                                                const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(old, PackedTile::open(copy.from, copy.tile));
  std::vector<PackedArray> packed;
  for (const auto& column : columns) packed.push_back(PackedArray::plain(column.values));
  BOOST_OUTCOME_TRY(planned, plan(old, columns, packed));
  const std::string header = header_text(planned.header);
  BOOST_OUTCOME_TRY(file, DirectWriter::create(copy.to, copy.final_name, stop));
  BOOST_OUTCOME_TRYV(file.append(std::as_bytes(std::span(header))));
  std::vector<std::byte> buffer(sum_piece_bytes);
  for (const std::size_t i : planned.order) {
    BOOST_OUTCOME_TRYV(copy_raw(old, old.arrays()[i], buffer, file));
  }
  for (std::size_t k = 0; k < packed.size(); ++k) {
    BOOST_OUTCOME_TRYV(packed[k].write(file, header.size() + planned.header.offsets[planned.new_places[k]]));
  }
  BOOST_OUTCOME_TRYV(file.append(std::as_bytes(std::span(footer))));
  return file.finish();
}

}  // namespace tessera::store
