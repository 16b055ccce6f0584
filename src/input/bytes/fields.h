// Numbers inside records: copying a column of them from one type to another, and what an attribute may be called.
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

// Copies a column: `n` numbers, `from_stride` bytes apart, to places `to_stride` bytes apart. Integers out of the
// target's range become its nearest value, NaN becomes integer 0.
using ColumnCopy = void (*)(const std::byte* from, std::size_t from_stride, std::byte* to, std::size_t to_stride,
                            std::size_t n);
ColumnCopy column_copy(AttributeType from, bool byte_swapped, AttributeType to);

// Makes names of attributes fit to be names in XML, HDF5 and JSON: valid UTF-8 without '/' and control
// characters (see base/printable.h), at most 64 bytes, unique in the file, and none that means something else in a
// result ("id", "x", ...).
class AttributeNames {
 public:
  std::string make(std::string_view raw);

 private:
  std::unordered_set<std::string> taken_{"x", "y", "z", "id", "owner", "vtkGhostType"};
  std::unordered_map<std::string, int> next_;  // the number to try first: 4,000 columns of one name are no work
};

// Byte offset of each attribute in a row of `schema`.
std::vector<std::size_t> row_offsets(const std::vector<Attribute>& schema);

}  // namespace tessera
