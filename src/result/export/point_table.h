// The points of a result as a table with one row for each point of the input, in the order of the input. Duplicates
// have rows, too: those of the vertices that stand for them. Points that were filtered, or that had no valid
// coordinates, have none.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "src/base/attribute.h"
#include "src/result/export/mesh_source.h"

namespace tessera::exports {

// A number of each row.
struct TableColumn {
  std::string name;
  AttributeType type = AttributeType::f64;
  std::size_t offset = 0;  // in the row
  std::string unit = {};   // empty when it is unknown
};

class PointTable {
 public:
  // The columns are: id, the source index (u64); x, y and, in 3D, z (f64), within the box of a periodic result; vertex
  // (u64), the id of the vertex that stands for the point, if the result has duplicates; and the attributes in `names`,
  // all of them when `names` is empty. An attribute with the name of a column before it gets a trailing `_`. Errors:
  // usage when the result lacks a name, with those that the result has; those of reading the duplicates.
  static Result<PointTable> open(const MeshSource& source, const std::vector<std::string>& names);

  const std::vector<TableColumn>& columns() const { return columns_; }
  std::size_t row_bytes() const { return stride_; }
  std::uint64_t rows() const { return rows_; }
  // By the vertices that stand for them.
  std::span<const DuplicatePair> duplicates() const { return duplicates_; }
  // The vertex that stands for the point of a row.
  PointId vertex_of(const std::byte* row) const;
  // How many points are at the place of the vertex.
  std::uint64_t points_at(PointId vertex) const;

  // Calls `visit(rows)` with some rows at a time, packed, all in order. Rows wait in an unnamed file in `scratch`,
  // which takes row_bytes() for each. Needs the memory of the largest tile, and some 100 MiB; with more than 10^9
  // points a 4096th of the table. Errors: those of reading; corrupt when the ids of the vertices are not those of the
  // manifest; io; interrupted; those of `visit`.
  Status for_each(const std::filesystem::path& scratch,
                  const std::function<Status(std::span<const std::byte>)>& visit) const;

  std::span<const DuplicatePair> duplicates_of(PointId vertex) const;

 private:
  explicit PointTable(const MeshSource& source) : source_(&source) {}
  Status choose(const std::vector<std::string>& names);
  void add(std::string name, AttributeType type, std::string unit);

  // A part of a stored row that the table has.
  struct Piece {
    std::size_t from = 0, to = 0, bytes = 0;
  };
  const MeshSource* source_;
  std::vector<TableColumn> columns_;
  std::vector<Piece> pieces_;
  std::vector<DuplicatePair> duplicates_;  // by the vertex that stands for them
  std::size_t stride_ = 0, vertex_at_ = 0;
  std::uint64_t rows_ = 0;
};

// Rows that come in any order and leave by their ids. They wait in a file, in blocks of successive ids: a block is read
// back as a whole, and put in order in memory. So nothing is compared, and each row is written once and read once.
class RowsById {
 public:
  // A row has `stride` bytes, and begins with its id (u64), which is less than `ids`.
  static Result<RowsById> create(const std::filesystem::path& scratch, std::uint64_t ids, std::size_t stride);
  // Error corrupt for an id that is too large, or more rows than ids.
  Status push(std::span<const std::byte> row);
  // Calls `visit(rows)` with some rows at a time. Errors: io, those of `visit`, corrupt when two rows have one id.
  Status for_each(const std::function<Status(std::span<const std::byte>)>& visit);

 private:
  struct Block {
    std::vector<std::byte> waiting;
    std::uint64_t written = 0;  // rows
  };
  RowsById(FileHandle file, std::filesystem::path path, std::uint64_t ids, std::size_t stride);
  Status write(std::size_t index);
  Status give(std::size_t index, const std::function<Status(std::span<const std::byte>)>& visit);

  FileHandle file_;
  std::filesystem::path path_;
  std::uint64_t ids_;
  std::size_t stride_, waiting_bytes_;
  std::uint64_t block_ids_;
  std::vector<Block> blocks_;
};

}  // namespace tessera::exports
