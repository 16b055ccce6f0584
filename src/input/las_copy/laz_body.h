// The points of a LAZ file: its chunks and their table. The other half of chunk_table.h.
// Source: rapidlasso, LAZ Specification 1.4.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "src/base/files/output_file.h"
#include "src/base/result.h"
#include "src/input/las_copy/chunk_encoder.h"
#include "src/input/laz/chunk_decoder.h"
#include "src/input/laz/laz_layout.h"

namespace tessera::laz {

// The payload of the LASzip record of `layout`. `before` is that of the input, whose version and options are kept;
// empty if there is none. REQUIRES: `before` is empty or was read by read_laz_layout().
std::vector<std::byte> laszip_payload(const LazLayout& layout, std::span<const std::byte> before);

// Compresses records and appends them to a file. For each thread there is one chunk in memory: up to 16 MiB of its
// records, and its compressed bytes.
class LazBody {
 public:
  // `at`: the bytes that `file` has already. `threads` compress chunks, each a chunk of its own. REQUIRES: that of
  // make_chunk_encoder(); threads > 0; `file` outlives this.
  LazBody(OutputFile& file, const LazLayout& layout, std::size_t record_bytes, std::uint64_t at, unsigned threads = 1);

  Status begin();
  // Whole records. A chunk ends when it has layout.chunk_points points. Errors: those of the file; bad_input when a
  // chunk becomes longer than the chunk table can say.
  Status add(std::span<const std::byte> records);
  // Ends the chunk, if it has points. For a layout of variable chunks, and at the end.
  Status end_chunk();
  // Ends the last chunk, and writes the table.
  Status finish();

  // The chunks in the file, and the bytes of the file. REQUIRES: after finish().
  const std::vector<Chunk>& chunks() const { return chunks_; }
  std::uint64_t end() const { return end_; }

 private:
  struct Part {
    std::vector<std::byte> records;         // those that are still to be encoded
    std::unique_ptr<ChunkEncoder> encoder;  // has the records before them, if there are any
    std::uint64_t points = 0;
  };

  void encode(Part& part) const;
  Status compress_ended();
  Status append(std::span<const std::byte> bytes);
  std::vector<std::byte> table() const;

  OutputFile& file_;
  LazLayout layout_;
  std::size_t record_bytes_;
  unsigned threads_;
  std::uint64_t begin_, end_;
  Part part_;                // the chunk that has not ended
  std::vector<Part> ended_;  // fewer than threads_
  std::vector<Chunk> chunks_;
};

}  // namespace tessera::laz
