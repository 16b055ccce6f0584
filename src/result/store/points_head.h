// What a file of points begins with: what is in it, and where. FORMAT.md gives its grammar.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/ids.h"

namespace tessera::store {

// A column of the file.
struct PointsColumn {
  enum class What : std::uint8_t { x, y, z, id, owner, named };
  enum class Of : std::uint8_t { own, foreign, cells };
  What what = What::x;
  Of of = Of::own;
  std::size_t number = 0;  // of a named one, in PointsHead::schema() or cell_schema()
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
  std::uint64_t own = 0, foreign = 0, cells = 0;
  struct Named {
    bool of_cells = false;  // else of the points: an attribute
    Attribute as;
  };
  std::vector<Named> named;   // in the order in which they came: each behind all that was there
  std::vector<Block> blocks;  // end to end behind the head

  std::vector<Attribute> schema() const;       // of the points
  std::vector<Attribute> cell_schema() const;  // of the cells
  // In the file's order: without some of the named ones that came last, it is a beginning.
  std::vector<PointsColumn> columns() const;
  std::uint64_t block_count() const;
  std::uint64_t bytes() const;  // of the head
  // "own points, x", "cells, column 'volume'"
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
