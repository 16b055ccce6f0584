// Decodes several chunks at once and hands out their points in the order of the file.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <span>
#include <thread>
#include <vector>

#include "src/base/result.h"
#include "src/input/laz/chunk_decoder.h"

namespace tessera::laz {

// Consecutive records of one chunk.
struct RecordBlock {
  std::uint64_t first = 0;  // the rank in the file of the first record
  std::size_t records = 0;
  std::vector<std::byte> bytes;
};

// The most records in a block, so that a block takes some 4 MiB.
std::size_t block_records(std::size_t record_bytes);

// Returns `reason` as the error of a chunk, with the file and the records.
Error chunk_error(const ByteSource& source, const Chunk& chunk, const Error& reason);

// Threads take the chunks in order. They may be ahead of the reader by as many chunks as there are threads. At most two
// blocks of each chunk wait, so memory does not depend on the size of a chunk.
class ChunkPipeline {
 public:
  // REQUIRES: threads > 0; all references outlive this.
  ChunkPipeline(const ByteSource& source, const LazLayout& layout, const WantedFields& plan,
                std::span<const Chunk> chunks, unsigned threads);
  ChunkPipeline(const ChunkPipeline&) = delete;
  ChunkPipeline& operator=(const ChunkPipeline&) = delete;
  ~ChunkPipeline();

  // Replaces `block` by the next block. A block without records is the end. Errors are those of the chunk decoders,
  // returned where the points are missing. REQUIRES: no call follows an error.
  Status next(RecordBlock& block);

 private:
  struct Slot {
    std::deque<RecordBlock> blocks;
    bool done = false;
    Status status = success();
  };

  void work();
  void stop();
  Status bring_from(std::size_t chunk);
  Status decode(std::size_t chunk);
  Slot& slot(std::size_t chunk) { return slots_[chunk % slots_.size()]; }

  const ByteSource& source_;
  const LazLayout& layout_;
  const WantedFields& plan_;
  std::span<const Chunk> chunks_;

  std::mutex bringing_;      // held while chunks of a far source are fetched: threads that need them wait
  std::size_t brought_ = 0;  // chunks before this one were fetched
  std::mutex mutex_;
  std::condition_variable changed_;
  // the number of chunks that threads have begun; the chunk at which the reader is
  std::size_t taken_ = 0, front_ = 0;
  bool stop_ = false;
  std::vector<Slot> slots_;
  std::vector<std::vector<std::byte>> spare_;  // the memory of blocks that were read
  std::vector<std::jthread> threads_;
};

}  // namespace tessera::laz
