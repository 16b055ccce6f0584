// One chunk of points, compressed. The other half of chunk_decoder.h.
// Source: rapidlasso, LAZ Specification 1.4; LASzip, design/specification.rst.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "src/input/laz/laz_layout.h"

namespace tessera::laz {

// Encodes a chunk from its first point to its last, in as many calls as the caller likes. Keeps the compressed bytes in
// memory, because a layered chunk begins with the lengths of its layers.
class ChunkEncoder {
 public:
  virtual ~ChunkEncoder() = default;
  // REQUIRES: `records` are whole records; together fewer than 2^32 of a chunk.
  virtual void encode(std::span<const std::byte> records) = 0;
  // Returns the bytes of the chunk. REQUIRES: the chunk has a point; nothing is encoded afterwards.
  virtual std::vector<std::byte> finish() = 0;
};

// Makes the encoder of a chunk of records of `record_bytes` bytes. REQUIRES: `layout` is chunked; its items are those
// of standard_layout(), but items of the layered compressor may also have version 4.
std::unique_ptr<ChunkEncoder> make_chunk_encoder(const LazLayout& layout, std::size_t record_bytes);
std::unique_ptr<ChunkEncoder> make_pointwise_encoder(const LazLayout& layout, std::size_t record_bytes);
std::unique_ptr<ChunkEncoder> make_layered_encoder(const LazLayout& layout, std::size_t record_bytes);

}  // namespace tessera::laz
