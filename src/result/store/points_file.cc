#include "src/result/store/points_file.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "src/base/check.h"
#include "src/base/image.h"
#include "src/result/store/points_blocks.h"
#include "src/result/store/points_reader.h"

namespace tessera {

namespace fs = std::filesystem;
using namespace store;

BigVector<std::byte> points_file_bytes(const PointsTileView& tile) {
  const std::size_t n = tile.points.size(), stride = row_bytes(tile.schema);
  check(n <= points_rows_max && tile.cells <= points_rows_max && tile.own <= n && tile.ids.size() == n &&
            tile.owners.size() == n && tile.rows.size() == n * stride,
        "a tile's points, ids, owners and rows are as many");
  PointsHead head{tile.dimension, tile.tile, tile.own, n - tile.own, tile.cells, {}, {}};
  for (const Attribute& attribute : tile.schema) head.named.push_back({false, attribute});
  BigVector<std::byte> bytes(head.bytes());
  ColumnBlocks blocks;
  for (const PointsColumn& column : head.columns())
    append_column(place_in<const std::byte>(tile, stride, column), blocks, head, bytes);
  write_points_head(head, std::span(bytes).first(head.bytes()));
  return bytes;
}

Result<PointsHead> read_points_head(DataFile file, TileId tile) {
  BOOST_OUTCOME_TRY(reader, PointsReader::open(FileBytes(std::move(file)), tile));
  return reader.head();
}

Result<PointsTile> read_points_file(DataFile file, TileId tile, const PointsFields& fields) {
  BOOST_OUTCOME_TRY(reader, PointsReader::open(FileBytes(std::move(file)), tile));
  return reader.read(fields);
}

Result<std::vector<PointId>> read_own_point_ids(DataFile file, TileId tile) {
  BOOST_OUTCOME_TRY(reader, PointsReader::open(FileBytes(std::move(file)), tile));
  return reader.read_ids(PointsColumn::Of::own);
}

Result<PointsHead> read_points_head(const fs::path& path, TileId tile) {
  BOOST_OUTCOME_TRY(file, DataFile::open(path));
  return read_points_head(std::move(file), tile);
}

Result<PointsTile> read_points_file(const fs::path& path, TileId tile, const PointsFields& fields) {
  BOOST_OUTCOME_TRY(file, DataFile::open(path));
  return read_points_file(std::move(file), tile, fields);
}

Result<std::vector<PointId>> read_own_point_ids(const fs::path& path, TileId tile) {
  BOOST_OUTCOME_TRY(file, DataFile::open(path));
  return read_own_point_ids(std::move(file), tile);
}

Result<PointsTile> parse_points_file(std::span<const std::byte> bytes, const fs::path& name, TileId tile) {
  BOOST_OUTCOME_TRY(reader, PointsReader::open(FileBytes(bytes, name), tile));
  return reader.read({});
}

std::vector<std::uint32_t> by_id(std::span<const PointId> ids) {
  std::vector<std::uint32_t> order(ids.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](auto a, auto b) {
    const PointId p = ids[a], q = ids[b];
    return plain(p) != plain(q) ? plain(p) < plain(q) : p < q;
  });
  return order;
}

}  // namespace tessera
