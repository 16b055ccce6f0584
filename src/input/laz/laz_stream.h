// The records of a LAZ file, read as if they were not compressed.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "src/input/bytes/record_stream.h"
#include "src/input/laz/chunk_pipeline.h"

namespace tessera::laz {

// Reads `chunks` in order. Callers that ask for full batches are served by `threads` threads, at most eight. Callers
// that ask for a few points at a time (a sample, after a seek) are served by one decoder, which starts at the beginning
// of the chunk.
class LazStream : public RecordSource {
 public:
  // `chunks`: some or all chunks of the file, in the order of the file. Each has points.
  LazStream(std::unique_ptr<ByteSource> source, LazLayout layout, WantedFields plan, std::vector<Chunk> chunks,
            unsigned threads);

  Result<std::span<const std::byte>> next(std::size_t most) override;
  // Makes the record with this rank among the records of `chunks` the next one.
  void seek(std::uint64_t record) override;
  std::size_t record_bytes() const override { return plan_.record_bytes; }
  std::uint64_t first_of_last_block() const override { return first_; }

 private:
  Result<std::span<const std::byte>> from_pipeline(std::size_t most);
  Result<std::span<const std::byte>> from_decoder(std::size_t most);
  Status decode(std::size_t records);
  Status bring_next();

  std::unique_ptr<ByteSource> source_;
  LazLayout layout_;
  WantedFields plan_;
  std::vector<Chunk> chunks_;
  unsigned threads_;

  std::uint64_t first_ = 0;
  std::size_t chunk_ = 0;     // the chunk of the next record
  std::uint64_t offset_ = 0;  // the next record's rank in that chunk
  std::unique_ptr<ChunkDecoder> decoder_;
  std::uint64_t decoded_ = 0;  // records of chunk_ that decoder_ has returned
  RecordBlock block_;
  std::size_t brought_ = 0, ahead_ = 1;  // of a far source: chunks before brought_ were fetched, ahead_ at a time
  std::size_t used_ = 0;                 // records of block_ that were returned, if it is the pipeline's
  std::unique_ptr<ChunkPipeline> pipeline_;
};

}  // namespace tessera::laz
