// One chunk of compressed points. A chunk can be decoded without the others.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"
#include "src/input/laz/laz_layout.h"

namespace tessera::laz {

// Where a chunk is in the file, and which points it has, in the order of the file.
struct Chunk {
  std::uint64_t begin = 0, end = 0;  // the chunk's first byte in the file, and the byte after its last
  std::uint64_t first = 0, points = 0;
};

// What is to be decoded of records of `record_bytes` bytes.
struct WantedFields {
  std::size_t record_bytes = 0;
  // For each byte of a record, whether the caller needs it. In point formats 6-8, layers without such a byte are not
  // read. x, y and z are always decoded.
  std::vector<bool> wanted;
};

// Decodes a chunk from its first point to its last, in as many calls as the caller likes.
class ChunkDecoder {
 public:
  virtual ~ChunkDecoder() = default;
  // Writes the next `n` records to `records`. Bytes that are not wanted keep their value or become zero. Errors:
  // bad_input if the compressed bytes end too early; io if they cannot be read. The error is a reason without file and
  // place, which the caller adds. REQUIRES: no call follows an error, or asks for more points than the chunk has.
  virtual Status decode(std::size_t n, std::byte* records) = 0;
  // To be called after the last point: error bad_input if compressed bytes of the chunk are left over. LAZ has no
  // checksum, but a decoder that was misled by a wrong bit nearly always ends at the wrong byte.
  virtual Status check_end() const = 0;
};

// Makes the decoder of a chunk. `source` must outlive the decoder; `layout` and `plan` need not. REQUIRES:
// layout.compressor is not none; chunk.begin <= chunk.end <= source.size(). make_layered_decoder() is for
// layered_chunked only.
std::unique_ptr<ChunkDecoder> make_chunk_decoder(const ByteSource& source, const LazLayout& layout,
                                                 const WantedFields& plan, const Chunk& chunk);
std::unique_ptr<ChunkDecoder> make_layered_decoder(const ByteSource& source, const LazLayout& layout,
                                                   const WantedFields& plan, const Chunk& chunk);

// Errors of both kinds of decoders: bytes were missing, or bytes are left over.
Status check_stream(const class ByteFeed& feed);
Status check_stream_end(const class ByteFeed& feed);

}  // namespace tessera::laz
