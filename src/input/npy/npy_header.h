// The header of a NumPy file: which columns the rows have.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"

namespace tessera {

struct NpyColumn {
  std::string name;  // as in the header
  AttributeType type = AttributeType::f64;
  bool swapped = false;    // big endian
  std::size_t offset = 0;  // in bytes, within the row
};

struct NpyHeader {
  std::uint64_t body_at = 0;  // the offset of the first row
  std::uint64_t rows = 0;
  std::size_t row_bytes = 0;
  std::vector<NpyColumn> columns;  // an array without names has x, y, z, column_4, ...
  bool named = false;              // whether the array has names
  std::string detail;              // "NumPy <f8, n x 3"
};

// Errors, which name the path, for what is no NumPy file, and for arrays that are not points.
Result<NpyHeader> read_npy_header(const ByteSource& source);
// Reads a list of integers that are not negative: an array of one dimension, of integers of 4 or 8 bytes. Errors, which
// name the path, for everything else.
Result<std::vector<std::uint64_t>> read_npy_integers(const ByteSource& source);

}  // namespace tessera
