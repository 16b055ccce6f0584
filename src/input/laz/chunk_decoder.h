// One chunk of compressed points: what can be decoded without looking at any other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"
#include "src/input/laz/laz_layout.h"

namespace tessera::laz {

// Where a chunk stands in the file, and its points in the order of the file.
struct Chunk {
  std::uint64_t begin = 0, end = 0;  // bytes
  std::uint64_t first = 0, points = 0;
};

// What is to be decoded of records of `record_bytes` bytes.
struct RecordPlan {
  std::size_t record_bytes = 0;
  // For each byte of a record, whether anybody will look at it. Layers of point formats 6-8 with no such byte are not
  // read; x, y, z always are.
  std::vector<bool> wanted;
};

// Decodes a chunk from its first point to its last, in as many steps as the caller likes.
class ChunkDecoder {
 public:
  virtual ~ChunkDecoder() = default;
  // The next `n` records, one after the other, to `records`. Bytes that nobody wanted are left as they are or zero.
  // Error bad_input if the compressed bytes end before, io if they cannot be read: a reason without file and place,
  // which the caller knows better. REQUIRES: no more calls after an error, nor for more points than the chunk has.
  virtual Status decode(std::size_t n, std::byte* records) = 0;
  // After the last point: error bad_input if compressed bytes of the chunk are left over. LAZ has no checksum, but a
  // coder that was misled by a wrong bit nearly always ends at the wrong byte.
  virtual Status check_end() const = 0;
};

// `source` must outlive the decoder; `layout` and `plan` need not. REQUIRES: layout.compressor is not none;
// chunk.begin <= chunk.end <= source.size().
std::unique_ptr<ChunkDecoder> make_chunk_decoder(const ByteSource& source, const LazLayout& layout,
                                                 const RecordPlan& plan, const Chunk& chunk);
std::unique_ptr<ChunkDecoder> make_layered_decoder(const ByteSource& source, const LazLayout& layout,
                                                   const RecordPlan& plan, const Chunk& chunk);

// The reasons both kinds give.
Status check_stream(const class ByteFeed& feed);
Status check_stream_end(const class ByteFeed& feed);

}  // namespace tessera::laz
