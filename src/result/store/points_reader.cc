#include "src/result/store/points_reader.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "src/base/files/checksum.h"
#include "src/result/store/points_blocks.h"

namespace tessera::store {

namespace {

using What = PointsColumn::What;
using Of = PointsColumn::Of;

bool is_negative_zero(double value) { return value == 0 && std::signbit(value); }

std::uint64_t end_of(std::uint64_t block, std::uint64_t rows) {
  return std::min<std::uint64_t>((block + 1) * block_rows, rows);
}

}  // namespace

Result<std::span<const std::byte>> FileBytes::at(std::uint64_t offset, std::uint64_t bytes) {
  if (!file_) {
    const auto rest = memory_.subspan(std::min<std::uint64_t>(offset, memory_.size()));
    return rest.first(std::min<std::uint64_t>(bytes, rest.size()));
  }
  buffer_.resize(bytes);
  BOOST_OUTCOME_TRY(read, file_->read_up_to(offset, buffer_));
  return std::span<const std::byte>(buffer_).first(read);
}

Result<PointsReader> PointsReader::open(FileBytes file, TileId tile) {
  PointsReader reader(std::move(file));
  BOOST_OUTCOME_TRYV(reader.read_head(tile));
  return reader;
}

Result<PointsTile> PointsReader::read(const PointsFields& fields) {
  PointsTile tile;
  tile.dimension = head_.dimension;
  tile.tile = head_.tile;
  tile.own = head_.own;
  tile.schema = head_.schema();
  tile.cells = head_.cells;
  tile.cell_schema = head_.cell_schema();
  BOOST_OUTCOME_TRYV(read_points(fields, tile));
  if (!fields.cell_columns) return tile;
  for (const PointsColumn& column : head_.columns()) {
    if (column.of != Of::cells) continue;
    const std::size_t size = size_of(column.type);
    auto& values = tile.cell_columns.emplace_back(column.rows * size);
    BOOST_OUTCOME_TRYV(read_column(column, {column.type, values.data(), size, column.rows}));
  }
  return tile;
}

Status PointsReader::read_points(const PointsFields& fields, PointsTile& tile) {
  const std::size_t n = head_.own + head_.foreign, stride = row_bytes(tile.schema);
  tile.points.resize(n);
  tile.ids.resize(n);
  tile.owners.resize(n, head_.tile);
  if (fields.rows) tile.rows.resize(n * stride);
  auto columns = head_.columns();
  if (!fields.rows) std::erase_if(columns, [](const PointsColumn& column) { return column.what == What::named; });
  for (const Of of : {Of::own, Of::foreign})
    for (std::uint64_t block = 0; block * block_rows < (of == Of::own ? head_.own : head_.foreign); ++block) {
      // Reads a block of each column before the next block of any, because the columns' values are side by side in
      // memory.
      for (const PointsColumn& column : columns) {
        if (column.of != of) continue;
        BOOST_OUTCOME_TRYV(read_block(column, block, place_in<std::byte>(tile, stride, column)));
      }
      BOOST_OUTCOME_TRYV(check_values(tile, of, block));
    }
  return success();
}

Result<std::vector<PointId>> PointsReader::read_ids(Of of) {
  std::vector<PointId> ids(of == Of::own ? head_.own : head_.foreign);
  for (const PointsColumn& column : head_.columns()) {
    if (column.what != What::id || column.of != of) continue;
    BOOST_OUTCOME_TRYV(
        read_column(column, {column.type, reinterpret_cast<std::byte*>(ids.data()), sizeof(PointId), ids.size()}));
  }
  return ids;
}

Status PointsReader::read_raw(const std::function<Status(std::span<const std::byte>)>& take) {
  constexpr std::uint64_t piece = std::uint64_t{1} << 20;
  for (std::uint64_t at = head_.bytes(); at < file_.bytes();) {
    BOOST_OUTCOME_TRY(bytes, file_.at(at, std::min(piece, file_.bytes() - at)));
    if (bytes.empty()) return corrupt("blocks", "are cut off by the end of the file");
    BOOST_OUTCOME_TRYV(take(bytes));
    at += bytes.size();
  }
  return success();
}

Error PointsReader::corrupt(const std::string& place, const std::string& reason) const {
  return error(Errc::corrupt, file_.path().string() + ", " + place + ": " + reason);
}

Status PointsReader::read_head(TileId tile) {
  std::uint64_t wanted = 1 << 16;
  while (true) {
    BOOST_OUTCOME_TRY(bytes, file_.at(0, std::min(wanted, file_.bytes())));
    auto parsed = parse_points_head(bytes, file_.bytes());
    if (const auto* wrong = std::get_if<std::string>(&parsed)) return corrupt("head", *wrong);
    if (auto* head = std::get_if<PointsHead>(&parsed)) {
      head_ = std::move(*head);
      break;
    }
    if (bytes.size() < wanted) return corrupt("head", "ends too early");
    wanted = std::get<std::uint64_t>(parsed);
  }
  if (head_.tile != tile) return corrupt("head", "is that of tile " + to_string(head_.tile));
  std::uint64_t at = head_.bytes();
  for (const PointsHead::Block& block : head_.blocks) {
    begins_.push_back(at);
    at += block.bytes;
  }
  return success();
}

Status PointsReader::read_column(const PointsColumn& column, const ColumnBuffer& room) {
  for (std::uint64_t block = 0; block < column.blocks; ++block) {
    BOOST_OUTCOME_TRYV(read_block(column, block, room));
  }
  return success();
}

Status PointsReader::read_block(const PointsColumn& column, std::uint64_t block, const ColumnBuffer& room) {
  const std::uint64_t number = column.first_block + block;
  const PointsHead::Block& entry = head_.blocks[number];
  BOOST_OUTCOME_TRY(bytes, file_.at(begins_[number], entry.bytes));
  const char* wrong = bytes.size() < entry.bytes ? "is cut off by the end of the file"
                      : checksum(bytes, number) != entry.xxh3
                          ? "is damaged"
                          : blocks_.take(bytes, room.part(block * block_rows, end_of(block, column.rows)));
  if (wrong != nullptr) return corrupt(head_.place(column) + ", block " + std::to_string(block), wrong);
  return success();
}

Status PointsReader::check_values(const PointsTile& tile, Of of, std::uint64_t block) const {
  const std::uint64_t first = of == Of::own ? 0 : tile.own;
  const std::uint64_t end = first + end_of(block, of == Of::own ? head_.own : head_.foreign);
  for (std::uint64_t i = first + block * block_rows; i < end; ++i) {
    const Point& p = tile.points[i];
    const char* wrong = !is_finite(p)                                                             ? " is not finite"
                        : is_negative_zero(p.x) || is_negative_zero(p.y) || is_negative_zero(p.z) ? " is at -0"
                        : of == Of::foreign && tile.owners[i] == tile.tile
                            ? " belongs to the tile, but stands among the foreign points"
                            : nullptr;
    if (wrong != nullptr) return corrupt("points", "point " + std::to_string(i) + wrong);
  }
  return success();
}

}  // namespace tessera::store
