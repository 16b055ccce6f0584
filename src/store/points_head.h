// What a file of points begins with: what is in it, and where. FORMAT.md gives its grammar.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/big_vector.h"
#include "src/base/ids.h"

namespace tessera::store {

// A column of the file: of the own points, or of the foreign ones.
struct PointsColumn {
  enum class What : std::uint8_t { x, y, z, id, owner, attribute };
  What what = What::x;
  bool own = true;
  std::size_t attribute = 0;  // in the schema
  AttributeType type = AttributeType::f64;
  std::uint64_t rows = 0;
  std::uint64_t first_block = 0, blocks = 0;  // in the table
};

struct PointsHead {
  struct Block {
    std::uint32_t bytes = 0;
    std::uint64_t xxh3 = 0;  // seeded with its number
  };
  int dimension = 3;
  TileId tile;
  std::uint64_t own = 0, foreign = 0;
  std::vector<Attribute> schema;
  std::vector<Block> blocks;  // end to end behind the head

  // In the file's order: without the attributes, it is a beginning.
  std::vector<PointsColumn> columns() const;
  std::uint64_t block_count() const;
  std::uint64_t bytes() const;  // of the head
  // "own points, x"
  std::string place(const PointsColumn& column) const;
};

inline constexpr std::uint64_t points_rows_max = std::uint64_t{1} << 31u;

// REQUIRES: head.blocks are block_count(), and `to` has head.bytes(). Tests forge others, of another size.
void write_points_head(const PointsHead& head, std::span<std::byte> to);

// `bytes`: a beginning of a file of `file_bytes`. How many bytes of it are needed, when these are too few; or what is
// wrong with them, as the end of a sentence. Memory is taken in proportion to `bytes`.
using ParsedHead = std::variant<PointsHead, std::uint64_t, std::string>;
ParsedHead parse_points_head(std::span<const std::byte> bytes, std::uint64_t file_bytes);

}  // namespace tessera::store
