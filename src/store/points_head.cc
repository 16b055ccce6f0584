#include "src/store/points_head.h"

#include <algorithm>
#include <cstring>
#include <string_view>

#include "src/base/check.h"
#include "src/base/flat_codec.h"
#include "src/base/printable.h"
#include "src/files/checksum.h"
#include "src/store/integer_block.h"
#include "src/store/tile_layout.h"

namespace tessera::store {

namespace {

constexpr std::string_view magic = "Tessera points 1\n";
// Behind the magic line.
struct Fixed {
  std::uint32_t head_bytes = 0, dimension = 0, tile = 0, own = 0, foreign = 0, attributes = 0;
};
constexpr std::size_t fixed_bytes = magic.size() + sizeof(Fixed);
static_assert(sizeof(Fixed) == 24);
constexpr std::size_t entry_bytes = 4 + 8, sum_bytes = 8;

constexpr std::uint64_t blocks_of(std::uint64_t rows) { return (rows + block_rows - 1) / block_rows; }

bool read_schema(FlatReader& reader, std::uint32_t count, std::vector<Attribute>& schema) {
  for (std::uint32_t i = 0; i < count; ++i) {
    Attribute& attribute = schema.emplace_back();
    if (!reader.value(attribute.type) || !reader.list(attribute.name)) return false;
    if (attribute.type > AttributeType::f64) return false;
  }
  const auto stored = stored_schema(schema);
  return stored.has_value() && stored.value() == schema;
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
    case PointsColumn::What::attribute:
      return "attribute";
  }
  return "";
}

}  // namespace

std::vector<PointsColumn> PointsHead::columns() const {
  using What = PointsColumn::What;
  std::vector<PointsColumn> columns;
  std::uint64_t block = 0;
  const auto add = [&](What what, AttributeType type, bool is_own, std::size_t attribute = 0) {
    const std::uint64_t rows = is_own ? own : foreign;
    columns.push_back({what, is_own, attribute, type, rows, block, blocks_of(rows)});
    block += blocks_of(rows);
  };
  for (const bool is_own : {true, false}) {
    add(What::x, AttributeType::f64, is_own);
    add(What::y, AttributeType::f64, is_own);
    if (dimension == 3) add(What::z, AttributeType::f64, is_own);
    add(What::id, AttributeType::u64, is_own);
    if (!is_own) add(What::owner, AttributeType::u32, is_own);
  }
  for (const bool is_own : {true, false})
    for (std::size_t i = 0; i < schema.size(); ++i) add(What::attribute, schema[i].type, is_own, i);
  return columns;
}

std::uint64_t PointsHead::block_count() const {
  const auto coordinates_and_id = static_cast<std::uint64_t>(dimension) + 1;
  return blocks_of(own) * (coordinates_and_id + schema.size()) +
         blocks_of(foreign) * (coordinates_and_id + 1 + schema.size());
}

std::uint64_t PointsHead::bytes() const {
  std::uint64_t bytes = fixed_bytes + block_count() * entry_bytes + sum_bytes;
  for (const Attribute& attribute : schema) bytes += 1 + 8 + attribute.name.size();
  return bytes;
}

std::string PointsHead::place(const PointsColumn& column) const {
  return std::string(column.own ? "own" : "foreign") + " points, " +
         (column.what == PointsColumn::What::attribute ? "attribute " + in_quotes(schema[column.attribute].name)
                                                       : name_of(column.what));
}

void write_points_head(const PointsHead& head, std::span<std::byte> to) {
  FlatWriter writer;
  for (const char letter : magic) writer.value(letter);
  writer.value(Fixed{static_cast<std::uint32_t>(to.size()), static_cast<std::uint32_t>(head.dimension), head.tile.value,
                     static_cast<std::uint32_t>(head.own), static_cast<std::uint32_t>(head.foreign),
                     static_cast<std::uint32_t>(head.schema.size())});
  for (const Attribute& attribute : head.schema) {
    writer.value(attribute.type);
    writer.list(attribute.name);
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
  const std::string damaged = "is not that of a file of points, or damaged";
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
  if (std::uint64_t{fixed.own} + fixed.foreign > points_rows_max) return std::string("tells of too many points");
  PointsHead head;
  head.dimension = static_cast<int>(fixed.dimension);
  head.tile = TileId{fixed.tile};
  head.own = fixed.own;
  head.foreign = fixed.foreign;
  FlatReader reader(summed.subspan(fixed_bytes));
  if (!read_schema(reader, fixed.attributes, head.schema)) return std::string("has attributes that cannot be");
  if (head.bytes() != fixed.head_bytes || !read_blocks(reader, head.block_count(), head.blocks))
    return std::string("has another number of blocks than of points");
  std::uint64_t end = fixed.head_bytes;
  for (const PointsHead::Block& block : head.blocks) end += block.bytes;
  if (end != file_bytes) return "ends its blocks at byte " + std::to_string(end) + ", not where the file ends";
  return head;
}

}  // namespace tessera::store
