#include "src/result/store/points_head.h"

#include <algorithm>
#include <cstring>
#include <string_view>
#include <utility>

#include "src/base/check.h"
#include "src/base/files/checksum.h"
#include "src/base/flat_codec.h"
#include "src/base/printable.h"
#include "src/result/store/integer_block.h"
#include "src/result/store/tile_layout.h"

namespace tessera::store {

namespace {

constexpr std::string_view magic = "Tessera points 2\n";
// The numbers after the magic line.
struct Fixed {
  std::uint32_t head_bytes = 0, dimension = 0, tile = 0, own = 0, foreign = 0, cells = 0, named = 0;
};
constexpr std::size_t fixed_bytes = magic.size() + sizeof(Fixed);
static_assert(sizeof(Fixed) == 28);
constexpr std::size_t entry_bytes = 4 + 8, sum_bytes = 8;

constexpr std::uint64_t blocks_of(std::uint64_t rows) { return (rows + block_rows - 1) / block_rows; }

bool read_named(FlatReader& reader, std::uint32_t count, PointsHead& head) {
  for (std::uint32_t i = 0; i < count; ++i) {
    std::uint8_t of_cells = 0;
    Attribute as;
    if (!reader.value(of_cells) || !reader.value(as.type) || !reader.list(as.name)) return false;
    if (of_cells > 1 || as.type > AttributeType::f64) return false;
    head.named.push_back({of_cells == 1, std::move(as)});
  }
  const auto can_be = [](const std::vector<Attribute>& schema, const Result<std::vector<Attribute>>& stored) {
    return stored.has_value() && stored.value() == schema;
  };
  const auto schema = head.schema(), cells = head.cell_schema();
  return can_be(schema, stored_schema(schema)) && can_be(cells, stored_cell_schema(cells));
}

bool read_blocks(FlatReader& reader, std::uint64_t count, std::vector<PointsHead::Block>& blocks) {
  blocks.reserve(count);
  for (std::uint64_t i = 0; i < count; ++i) {
    PointsHead::Block& block = blocks.emplace_back();
    if (!reader.value(block.bytes) || !reader.value(block.xxh3)) return false;
  }
  return reader.at_end();
}

const char* name_of(PointsColumn::What what) {
  switch (what) {
    case PointsColumn::What::x:
      return "x";
    case PointsColumn::What::y:
      return "y";
    case PointsColumn::What::z:
      return "z";
    case PointsColumn::What::id:
      return "id";
    case PointsColumn::What::owner:
      return "owner";
    case PointsColumn::What::named:
      break;
  }
  return "";
}

std::vector<Attribute> schema_of(const std::vector<PointsHead::Named>& named, bool of_cells) {
  std::vector<Attribute> schema;
  for (const PointsHead::Named& one : named)
    if (one.of_cells == of_cells) schema.push_back(one.as);
  return schema;
}

}  // namespace

std::vector<Attribute> PointsHead::schema() const { return schema_of(named, false); }
std::vector<Attribute> PointsHead::cell_schema() const { return schema_of(named, true); }

std::vector<PointsColumn> PointsHead::columns() const {
  using What = PointsColumn::What;
  using Of = PointsColumn::Of;
  std::vector<PointsColumn> columns;
  std::uint64_t block = 0;
  const auto add = [&](What what, AttributeType type, Of of, std::size_t number = 0) {
    const std::uint64_t rows = of == Of::own ? own : of == Of::foreign ? foreign : cells;
    columns.push_back({what, of, number, type, rows, block, blocks_of(rows)});
    block += blocks_of(rows);
  };
  for (const Of of : {Of::own, Of::foreign}) {
    add(What::x, AttributeType::f64, of);
    add(What::y, AttributeType::f64, of);
    if (dimension == 3) add(What::z, AttributeType::f64, of);
    add(What::id, AttributeType::u64, of);
    if (of == Of::foreign) add(What::owner, AttributeType::u32, of);
  }
  std::size_t of_points = 0, of_cells = 0;
  for (const Named& one : named) {
    if (one.of_cells) {
      add(What::named, one.as.type, Of::cells, of_cells++);
      continue;
    }
    for (const Of of : {Of::own, Of::foreign}) add(What::named, one.as.type, of, of_points);
    ++of_points;
  }
  return columns;
}

std::uint64_t PointsHead::block_count() const {
  const auto coordinates_and_id = static_cast<std::uint64_t>(dimension) + 1;
  const auto of_cells = static_cast<std::uint64_t>(std::ranges::count(named, true, &Named::of_cells));
  const std::uint64_t of_points = named.size() - of_cells;
  return blocks_of(own) * (coordinates_and_id + of_points) + blocks_of(foreign) * (coordinates_and_id + 1 + of_points) +
         blocks_of(cells) * of_cells;
}

std::uint64_t PointsHead::bytes() const {
  std::uint64_t bytes = fixed_bytes + block_count() * entry_bytes + sum_bytes;
  for (const Named& one : named) bytes += 1 + 1 + 8 + one.as.name.size();
  return bytes;
}

std::string PointsHead::place(const PointsColumn& column) const {
  const bool of_cells = column.of == PointsColumn::Of::cells;
  const std::string whose = of_cells                             ? "cells, "
                            : column.of == PointsColumn::Of::own ? "own points, "
                                                                 : "foreign points, ";
  if (column.what != PointsColumn::What::named) return whose + name_of(column.what);
  return whose + (of_cells ? "column " : "attribute ") + in_quotes(schema_of(named, of_cells)[column.number].name);
}

void write_points_head(const PointsHead& head, std::span<std::byte> to) {
  FlatWriter writer;
  for (const char letter : magic) writer.value(letter);
  writer.value(Fixed{static_cast<std::uint32_t>(to.size()), static_cast<std::uint32_t>(head.dimension), head.tile.value,
                     static_cast<std::uint32_t>(head.own), static_cast<std::uint32_t>(head.foreign),
                     static_cast<std::uint32_t>(head.cells), static_cast<std::uint32_t>(head.named.size())});
  for (const PointsHead::Named& one : head.named) {
    writer.value(static_cast<std::uint8_t>(one.of_cells ? 1 : 0));
    writer.value(one.as.type);
    writer.list(one.as.name);
  }
  for (const PointsHead::Block& block : head.blocks) {
    writer.value(block.bytes);
    writer.value(block.xxh3);
  }
  const auto bytes = writer.take();
  check(bytes.size() + sum_bytes == to.size(), "the head of a file of points has its size");
  const std::uint64_t sum = checksum(bytes);
  std::ranges::copy(bytes, to.begin());
  std::memcpy(to.data() + bytes.size(), &sum, sum_bytes);
}

ParsedHead parse_points_head(std::span<const std::byte> bytes, std::uint64_t file_bytes) {
  const std::string damaged = "is damaged, or not that of a file of points";
  if (bytes.size() < fixed_bytes) return file_bytes < fixed_bytes ? ParsedHead(damaged) : std::uint64_t{fixed_bytes};
  if (!std::ranges::equal(bytes.first(magic.size()), std::as_bytes(std::span(magic)))) return damaged;
  Fixed fixed;
  std::memcpy(&fixed, bytes.data() + magic.size(), sizeof fixed);
  if (fixed.head_bytes < fixed_bytes + sum_bytes || fixed.head_bytes > file_bytes) return damaged;
  if (fixed.head_bytes > bytes.size()) return std::uint64_t{fixed.head_bytes};

  const auto summed = bytes.first(fixed.head_bytes - sum_bytes);
  std::uint64_t sum = 0;
  std::memcpy(&sum, bytes.data() + summed.size(), sum_bytes);
  if (checksum(summed) != sum) return damaged;
  if (fixed.dimension != 2 && fixed.dimension != 3) return "has " + std::to_string(fixed.dimension) + " dimensions";
  if (std::uint64_t{fixed.own} + fixed.foreign > points_rows_max) return std::string("announces too many points");
  if (fixed.cells > points_rows_max) return std::string("announces too many cells");
  PointsHead head;
  head.dimension = static_cast<int>(fixed.dimension);
  head.tile = TileId{fixed.tile};
  head.own = fixed.own;
  head.foreign = fixed.foreign;
  head.cells = fixed.cells;
  FlatReader reader(summed.subspan(fixed_bytes));
  if (!read_named(reader, fixed.named, head)) return std::string("has impossible columns");
  if (head.bytes() != fixed.head_bytes || !read_blocks(reader, head.block_count(), head.blocks))
    return std::string("has a number of blocks that does not fit its rows");
  std::uint64_t end = fixed.head_bytes;
  for (const PointsHead::Block& block : head.blocks) end += block.bytes;
  if (end != file_bytes)
    return "says that the blocks end at byte " + std::to_string(end) + ", which is not the end of the file";
  return head;
}

}  // namespace tessera::store
