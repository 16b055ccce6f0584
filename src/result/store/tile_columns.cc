#include "src/result/store/tile_columns.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "src/base/files/checksum.h"
#include "src/base/files/names.h"
#include "src/result/store/packed_array.h"
#include "src/result/store/packed_tile.h"

namespace tessera::store {

namespace {

// The layout of the new file.
struct NewLayout {
  TileHeader header;
  std::vector<std::size_t> order;       // of the old arrays, as they follow each other in the file
  std::vector<std::size_t> new_places;  // of the columns, in the new header
};

// Old arrays keep their order, without gaps; the columns follow.
NewLayout plan(const PackedTile& old, std::span<const ColumnValues> columns, const std::vector<PackedArray>& packed) {
  NewLayout plan{.header = old.header(), .order = {}, .new_places = {}};
  TileHeader& header = plan.header;
  const std::size_t old_arrays = old.arrays().size(), vertices_end = first_attribute + header.schema.size();
  header.format = changed_format;
  for (const auto& column : columns) (column.of_cells ? header.cell_schema : header.schema).push_back(column.as);
  const auto infos = header.arrays();
  const std::size_t of_vertices = first_attribute + header.schema.size() - vertices_end;
  std::size_t next_vertices = vertices_end, next_cells = old_arrays + of_vertices;
  for (const auto& column : columns) plan.new_places.push_back(column.of_cells ? next_cells++ : next_vertices++);
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

// The indices of the file's cells in canonical order, which is that of their vertices. The file consists of a few
// stretches that are in this order.
Result<std::vector<std::uint32_t>> canonical_cells(const PackedTile& file) {
  std::vector<std::int32_t> vertices;
  BOOST_OUTCOME_TRYV(file.read_array(Section::cells, "connectivity", vertices));
  const auto corners = static_cast<std::size_t>(file.header().dimension) + 1;
  const auto less = [&](std::uint32_t a, std::uint32_t b) {
    const std::int32_t *left = vertices.data() + a * corners, *right = vertices.data() + b * corners;
    return std::lexicographical_compare(left, left + corners, right, right + corners);
  };
  std::vector<std::uint32_t> cells(file.header().cells);
  std::iota(cells.begin(), cells.end(), 0u);
  for (auto sorted = std::is_sorted_until(cells.begin(), cells.end(), less); sorted != cells.end();) {
    const auto end = std::is_sorted_until(sorted, cells.end(), less);
    std::inplace_merge(cells.begin(), sorted, end, less);
    sorted = end;
  }
  return cells;
}

// The values of cells in the order that the cells have in the file.
std::vector<std::byte> as_in_file(const ColumnValues& column, const std::vector<std::uint32_t>& canonical) {
  const std::size_t size = size_of(column.as.type);
  std::vector<std::byte> moved(column.values.size());
  for (std::size_t k = 0; k < canonical.size(); ++k)
    std::memcpy(moved.data() + canonical[k] * size, column.values.data() + k * size, size);
  return moved;
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
  BOOST_OUTCOME_TRY(from, DataFile::open(copy.from));
  BOOST_OUTCOME_TRY(old, PackedTile::open(std::move(from), copy.tile));
  std::vector<ColumnValues> placed(columns.begin(), columns.end());
  for (const auto& column : placed)
    if (column.values.size() != (column.of_cells ? old.header().cells : old.header().points) * size_of(column.as.type))
      return error(Errc::internal, "a column has not one value for each row");
  std::vector<std::vector<std::byte>> moved;
  if (copy.canonical) {
    BOOST_OUTCOME_TRY(cells, canonical_cells(old));
    for (auto& column : placed)
      if (column.of_cells) column.values = moved.emplace_back(as_in_file(column, cells));
  }
  std::vector<PackedArray> packed;
  for (const auto& column : placed) packed.push_back(PackedArray::plain(column.values));
  const NewLayout planned = plan(old, placed, packed);
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
