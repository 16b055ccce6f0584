// The pages of an E57 file. Each page of 1,024 bytes ends with a CRC-32C of the others. What the pages hold without
// their checksums is the logical file. Source: ASTM E2807-11, Standard Specification for 3D Imaging Data Exchange.
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <span>
#include <vector>

#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"

namespace tessera {

// Reads logical bytes, and checks the pages. Not thread-safe.
class E57Pages {
 public:
  E57Pages(std::unique_ptr<ByteSource> source, std::size_t page_bytes);

  // Fills `out` with the logical bytes from `at` on. Errors bad_input: the file ends before, or a page is damaged;
  // those of ByteSource::read().
  Status read(std::uint64_t at, std::span<std::byte> out);
  // The logical offset of a physical one, which the file's pointers are.
  std::uint64_t logical(std::uint64_t physical) const;
  std::uint64_t size() const;  // logical bytes
  const ByteSource& source() const { return *source_; }

 private:
  struct Block {
    std::uint64_t number;
    std::vector<std::byte> bytes;  // logical
  };

  Result<const Block*> block(std::uint64_t number);

  std::unique_ptr<ByteSource> source_;
  std::size_t page_bytes_;
  std::list<Block> blocks_;  // the last used first
};

}  // namespace tessera
