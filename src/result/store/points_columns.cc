// Adds columns to files of points. New columns come after all others, so the old blocks keep their numbers and are
// copied.
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <vector>

#include "src/base/big_vector.h"
#include "src/base/stopped.h"
#include "src/result/store/column_block.h"
#include "src/result/store/points_blocks.h"
#include "src/result/store/points_file.h"
#include "src/result/store/points_reader.h"
#include "src/result/store/tile_columns.h"

namespace tessera::store {

namespace {

// In the file, foreign points are in the order that suits a kernel; their values come in the order of ids.
BigVector<std::byte> as_in_file(std::span<const std::byte> values, std::size_t size,
                                const std::vector<std::uint32_t>& places) {
  BigVector<std::byte> moved(values.size());
  for (std::size_t k = 0; k < places.size(); ++k)
    std::memcpy(moved.data() + places[k] * size, values.data() + k * size, size);
  return moved;
}

}  // namespace

Result<DirectWriter::Written> copy_points_with_columns(const TileCopy& copy, std::span<const ColumnValues> columns,
                                                       const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(from, DataFile::open(copy.from));
  BOOST_OUTCOME_TRY(old, PointsReader::open(FileBytes(std::move(from)), copy.tile));
  PointsHead head = old.head();
  for (const ColumnValues& column : columns) {
    if (column.values.size() != (column.of_cells ? head.cells : head.own + head.foreign) * size_of(column.as.type))
      return error(Errc::internal, "a column has not one value for each row");
    head.named.push_back({column.of_cells, column.as});
  }
  BOOST_OUTCOME_TRY(ids, old.read_ids(PointsColumn::Of::foreign));
  const auto places = by_id(ids);
  BigVector<std::byte> made;
  ColumnBlocks blocks;
  for (const ColumnValues& column : columns) {
    throw_if_stopped(stop);
    const AttributeType type = column.as.type;
    const std::size_t size = size_of(type);
    if (column.of_cells) {
      append_column({type, column.values.data(), size, head.cells}, blocks, head, made);
      continue;
    }
    const auto foreign = as_in_file(column.values.subspan(head.own * size), size, places);
    append_column({type, column.values.data(), size, head.own}, blocks, head, made);
    append_column({type, foreign.data(), size, head.foreign}, blocks, head, made);
  }
  BigVector<std::byte> begin(head.bytes());
  write_points_head(head, begin);
  BOOST_OUTCOME_TRY(file, DirectWriter::create(copy.to, copy.final_name, stop));
  BOOST_OUTCOME_TRYV(file.append(begin));
  BOOST_OUTCOME_TRYV(old.read_raw([&](std::span<const std::byte> piece) { return file.append(piece); }));
  BOOST_OUTCOME_TRYV(file.append(made));
  return file.finish();
}

}  // namespace tessera::store
