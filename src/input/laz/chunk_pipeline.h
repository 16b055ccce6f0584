// Several chunks decoded at once, their points handed out in the order of the file.
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
  std::uint64_t first = 0;  // rank in the file of the first one
  std::size_t records = 0;
  std::vector<std::byte> bytes;
};

// How many records a block has at most, so that it takes some 4 MiB.
std::size_t block_records(std::size_t record_bytes);

// `reason` as the error of a chunk: names the file and the records.
Error chunk_error(const ByteSource& source, const Chunk& chunk, const Error& reason);

// Threads take the chunks in order, and may be ahead of the reader by as many chunks as there are threads, each with
// at most two blocks waiting: memory does not depend on the size of a chunk.
class ChunkPipeline {
 public:
  // REQUIRES: threads > 0; all references outlive this.
  ChunkPipeline(const ByteSource& source, const LazLayout& layout, const RecordPlan& plan,
                std::span<const Chunk> chunks, unsigned threads);
  ChunkPipeline(const ChunkPipeline&) = delete;
  ChunkPipeline& operator=(const ChunkPipeline&) = delete;
  ~ChunkPipeline();

  // Replaces `block` by the next one; one without records is the end. Errors are those of the chunk decoders, given at
  // the place where the points are missing: call no more after one.
  Status next(RecordBlock& block);

 private:
  struct Slot {
    std::deque<RecordBlock> blocks;
    bool done = false;
    Status status = success();
  };

  void work();
  void stop();
  Status decode(std::size_t chunk);
  Slot& slot(std::size_t chunk) { return slots_[chunk % slots_.size()]; }

  const ByteSource& source_;
  const LazLayout& layout_;
  const RecordPlan& plan_;
  std::span<const Chunk> chunks_;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t taken_ = 0, front_ = 0;  // chunks that a thread has begun; the one the reader is at
  bool stop_ = false;
  std::vector<Slot> slots_;
  std::vector<std::vector<std::byte>> spare_;  // memory of blocks that were read
  std::vector<std::jthread> threads_;
};

}  // namespace tessera::laz
