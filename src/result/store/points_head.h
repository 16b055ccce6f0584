// The head of a file of points: what the file has, and where. FORMAT.md has the grammar.
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
  std::size_t number = 0;  // for What::named: index in PointsHead::schema() or cell_schema()
  AttributeType type = AttributeType::f64;
  std::uint64_t rows = 0;
  std::uint64_t first_block = 0, blocks = 0;  // in the table of blocks
};

struct PointsHead {
  struct Block {
    std::uint32_t bytes = 0;
    std::uint64_t xxh3 = 0;  // seeded with the block's number
  };
  int dimension = 3;
  TileId tile;
  std::uint64_t own = 0, foreign = 0, cells = 0;
  struct Named {
    bool of_cells = false;  // else an attribute of the points
    Attribute as;
  };
  std::vector<Named> named;   // in the order in which they were added
  std::vector<Block> blocks;  // end to end, after the head

  std::vector<Attribute> schema() const;       // of the points
  std::vector<Attribute> cell_schema() const;  // of the cells
  // All columns in the file's order. Without some of the named columns that were added last, the list is a prefix.
  std::vector<PointsColumn> columns() const;
  std::uint64_t block_count() const;
  std::uint64_t bytes() const;  // of the head
  // Names a column for errors: "own points, x" or "cells, column 'volume'".
  std::string place(const PointsColumn& column) const;
};

inline constexpr std::uint64_t points_rows_max = std::uint64_t{1} << 31u;

// REQUIRES: head.blocks has block_count() elements, and `to` has head.bytes() bytes. Tests write other sizes to forge
// files.
void write_points_head(const PointsHead& head, std::span<std::byte> to);

// Parses the head of a file of `file_bytes` bytes; `bytes` is a prefix of the file. Returns the head; or the number of
// bytes that are needed, when these are too few; or what is wrong, as the end of a sentence. The memory needed is
// proportional to `bytes`.
using ParsedHead = std::variant<PointsHead, std::uint64_t, std::string>;
ParsedHead parse_points_head(std::span<const std::byte> bytes, std::uint64_t file_bytes);

}  // namespace tessera::store
