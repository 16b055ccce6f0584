#include "src/input/laz/chunk_pipeline.h"

#include <algorithm>
#include <new>
#include <string>
#include <utility>

#include "src/input/bytes/far_source.h"
#include "src/input/bytes/record_stream.h"
#include "src/input/laz/chunks_ahead.h"

namespace tessera::laz {
namespace {

constexpr std::size_t blocks_waiting_max = 2;

}  // namespace

std::size_t block_records(std::size_t record_bytes) {
  return std::clamp<std::size_t>(block_bytes_max / record_bytes, 1, batch_points_max);
}

Error chunk_error(const ByteSource& source, const Chunk& chunk, const Error& reason) {
  if (reason.code != Errc::bad_input) return reason;
  return error(Errc::bad_input, source.path().string() + ", chunk of records " + std::to_string(chunk.first) + " to " +
                                    std::to_string(chunk.first + chunk.points - 1) + ": " + reason.where);
}

ChunkPipeline::ChunkPipeline(const ByteSource& source, const LazLayout& layout, const WantedFields& plan,
                             std::span<const Chunk> chunks, unsigned threads)
    : source_(source), layout_(layout), plan_(plan), chunks_(chunks), slots_(threads + 1) {
  try {
    for (unsigned i = 0; i < threads; ++i) threads_.emplace_back([this] { work(); });
  } catch (...) {
    stop();  // the threads that were started
    throw;
  }
}

ChunkPipeline::~ChunkPipeline() { stop(); }

void ChunkPipeline::stop() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
}

void ChunkPipeline::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [&] { return stop_ || taken_ == chunks_.size() || taken_ < front_ + slots_.size(); });
    if (stop_ || taken_ == chunks_.size()) return;
    const std::size_t chunk = taken_++;
    lock.unlock();
    Status status = decode(chunk);
    lock.lock();
    slot(chunk).status = std::move(status);
    slot(chunk).done = true;
    changed_.notify_all();
  }
}

Status ChunkPipeline::bring_from(std::size_t chunk) {
  if (near_bytes_max(source_) == 0) return success();
  const std::lock_guard lock(bringing_);
  if (chunk < brought_) return success();
  const auto left = chunks_.subspan(chunk);
  const auto next = left.first(chunks_at_once(source_, left, chunks_ahead_max));
  BOOST_OUTCOME_TRYV(bring_chunks(source_, layout_, plan_, next));
  brought_ = chunk + next.size();
  return success();
}

Status ChunkPipeline::decode(std::size_t index) try {
  const Chunk& chunk = chunks_[index];
  BOOST_OUTCOME_TRYV(bring_from(index));
  const auto decoder = make_chunk_decoder(source_, layout_, plan_, chunk);
  const std::size_t most = block_records(plan_.record_bytes);
  for (std::uint64_t done = 0; done < chunk.points;) {
    RecordBlock block{.first = chunk.first + done,
                      .records = static_cast<std::size_t>(std::min<std::uint64_t>(most, chunk.points - done)),
                      .bytes = {}};
    {
      const std::lock_guard lock(mutex_);
      if (stop_) return success();
      if (!spare_.empty()) {
        block.bytes = std::move(spare_.back());
        spare_.pop_back();
      }
    }
    block.bytes.resize(block.records * plan_.record_bytes);
    BOOST_OUTCOME_TRYV(decoder->decode(block.records, block.bytes.data()));
    done += block.records;
    std::unique_lock lock(mutex_);
    auto& blocks = slot(index).blocks;
    changed_.wait(lock, [&] { return stop_ || blocks.size() < blocks_waiting_max; });
    blocks.push_back(std::move(block));
    changed_.notify_all();
  }
  return decoder->check_end();
} catch (const std::bad_alloc&) {
  return worded(
      [this] { return error(Errc::memory, source_.path().string() + ": no memory is left to decompress it"); });
}

Status ChunkPipeline::next(RecordBlock& block) {
  std::unique_lock lock(mutex_);
  if (!block.bytes.empty()) spare_.push_back(std::move(block.bytes));
  block = {};
  for (; front_ < chunks_.size(); ++front_) {
    Slot& at = slot(front_);
    changed_.wait(lock, [&] { return at.done || !at.blocks.empty(); });
    if (!at.blocks.empty()) {
      block = std::move(at.blocks.front());
      at.blocks.pop_front();
      changed_.notify_all();
      return success();
    }
    if (at.status.has_error()) return chunk_error(source_, chunks_[front_], at.status.error());
    at = {};
    changed_.notify_all();
  }
  return success();
}

}  // namespace tessera::laz
