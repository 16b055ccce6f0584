// Packs columns of a file of points in blocks of up to block_rows values of one type. No bit is lost.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/big_vector.h"
#include "src/result/store/grid_scale.h"
#include "src/result/store/integer_block.h"

namespace tessera::store {

// A column of values in memory, at any address, with `stride` bytes from one value to the next.
template <class Byte>
struct ColumnOf {
  AttributeType type = AttributeType::f64;
  Byte* first = nullptr;
  std::size_t stride = 8;
  std::size_t rows = 0;
  ColumnOf part(std::size_t begin, std::size_t end) const {
    return {type, first + begin * stride, stride, end - begin};
  }
};
using Column = ColumnOf<const std::byte>;
using ColumnBuffer = ColumnOf<std::byte>;

class ColumnBlocks {
 public:
  // Appends the column to `to` as one block. Equal values give equal bytes with the same version of zstd. REQUIRES: 1
  // to block_rows rows.
  void append(const Column& column, BigVector<std::byte>& to);
  // Reads a block that append() made of as many values of the same type. Uses all of `block`. Returns null, or what is
  // wrong with the block, as the end of a sentence.
  const char* take(std::span<const std::byte> block, const ColumnBuffer& column);

 private:
  std::optional<GridScale> find_scale();
  void append_doubles(BigVector<std::byte>& to);
  const char* take_doubles(std::span<const std::byte>& block, std::span<std::uint64_t> numbers);

  IntegerBlocks integers_;
  BigVector<std::uint64_t> numbers_, multiples_, misses_;
  std::vector<double> sample_;
};

}  // namespace tessera::store
