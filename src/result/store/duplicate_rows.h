// The attributes of duplicates, in a file beside duplicates.bin: a row for each pair, in the order of the pairs.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <stop_token>
#include <utility>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/files/mapped_file.h"
#include "src/base/ledger.h"
#include "src/base/result.h"
#include "src/result/store/external_sort.h"
#include "src/result/store/tile_store.h"

namespace tessera {

// The attributes that points have from the input: the schema without the computed columns.
std::vector<Attribute> carried_schema(const Manifest& manifest);

// A part of a row: a sorter needs records of one size.
struct RowPiece {
  PointId id;
  std::uint32_t number = 0;  // of the piece in the row
  std::array<std::byte, 20> bytes = {};
  friend bool operator<(const RowPiece& a, const RowPiece& b) {
    return std::pair(a.id, a.number) < std::pair(b.id, b.number);
  }
};

// Sorts rows that may not fit into memory by the source indices of their points.
class DuplicateRowSort {
 public:
  // `width`: the bytes of a row, at least 1.
  DuplicateRowSort(std::filesystem::path scratch, std::uint64_t memory_bytes, std::size_t width,
                   std::stop_token stop = Ledger::token_of_thread())
      : width_(width), pieces_(std::move(scratch), memory_bytes, std::move(stop)) {}

  Status push(PointId id, std::span<const std::byte> row);
  // Calls visit(bytes) with all rows, piece by piece. The sorter cannot be used afterwards.
  template <class Visit>
  Status for_each(const Visit& visit) {
    return pieces_.for_each([&](const RowPiece& piece) -> Status {
      return visit(std::span(piece.bytes).first(std::min(piece.bytes.size(), width_ - at(piece.number))));
    });
  }
  std::uint64_t rows() const { return rows_; }
  std::size_t width() const { return width_; }

 private:
  static std::size_t at(std::uint32_t piece) { return piece * std::tuple_size_v<decltype(RowPiece::bytes)>; }
  std::size_t width_;
  std::uint64_t rows_ = 0;
  ExternalSort<RowPiece> pieces_;
};

// The rows of a result, read where they are needed.
class DuplicateRows {
 public:
  // Nothing when the result does not keep the attributes of its duplicates: it was made by older software, or it has
  // no duplicates or no attributes. Checks the file. Errors: io; corrupt.
  static Result<std::optional<DuplicateRows>> open(const std::filesystem::path& out, const Manifest& manifest);

  // Of the pair with this number in read_duplicates().
  std::span<const std::byte> row(std::size_t pair) const { return file_.bytes().subspan(pair * width_, width_); }

 private:
  DuplicateRows(MappedFile file, std::size_t width) : file_(std::move(file)), width_(width) {}
  MappedFile file_;
  std::size_t width_;
};

namespace store {

// Writes the rows, and returns the XXH3-64 of the file. Without rows, removes the file of an earlier result and returns
// 0. `pairs`: how many rows there must be.
Result<std::uint64_t> write_duplicate_rows(const std::filesystem::path& out, DuplicateRowSort* rows,
                                           std::uint64_t pairs);
// Writes the rows to a new file of any name.
Result<std::uint64_t> write_rows(const std::filesystem::path& file, const std::filesystem::path& final_name,
                                 DuplicateRowSort& rows, std::uint64_t pairs);

}  // namespace store

}  // namespace tessera
