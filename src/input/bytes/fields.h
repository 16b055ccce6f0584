// Numbers in records: copies a column of numbers from one type to another. Also makes valid names for attributes.
#pragma once

#include <bit>
#include <cstddef>
#include <cstring>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "src/base/attribute.h"

namespace tessera {

static_assert(std::endian::native == std::endian::little, "file formats here are little endian; so must the host be");

// Reads a T at any address.
template <class T>
T load(const std::byte* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

// Copies a column: `n` numbers that are `from_stride` bytes apart, to places that are `to_stride` bytes apart. Integers
// out of the target's range become the nearest value in range. NaN becomes the integer 0.
using ColumnCopy = void (*)(const std::byte* from, std::size_t from_stride, std::byte* to, std::size_t to_stride,
                            std::size_t n);
// Returns the function that copies numbers of type `from` to type `to`. With byte_swapped the input is big endian.
ColumnCopy column_copy(AttributeType from, bool byte_swapped, AttributeType to);

// Makes names of attributes valid in XML, HDF5 and JSON: UTF-8 without '/' and control characters (see
// base/printable.h), at most 64 bytes, unique in the file, and different from names with a meaning in a result ("id",
// "x", ...).
class AttributeNames {
 public:
  // Returns the valid name for `raw`, and marks it as taken.
  std::string make(std::string_view raw);

 private:
  std::unordered_set<std::string> taken_{"x", "y", "z", "id", "owner", "vtkGhostType"};
  // the number to try first, so that 4,000 columns with one name take little time
  std::unordered_map<std::string, int> next_;
};

// The attributes of formats that say where the scanner was.
inline constexpr std::array<std::string_view, 3> scanner_position{"x_origin", "y_origin", "z_origin"};

// The byte offset of each attribute in a row of `schema`.
std::vector<std::size_t> row_offsets(const std::vector<Attribute>& schema);

}  // namespace tessera
