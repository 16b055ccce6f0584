#include "src/input/laz/laz_stream.h"

#include <algorithm>
#include <span>
#include <utility>

#include "src/input/bytes/far_source.h"
#include "src/input/laz/chunks_ahead.h"

namespace tessera::laz {
namespace {

// Each thread has up to 5 MiB waiting. Eight threads decode 30 million points a second, more than any caller takes.
constexpr unsigned threads_max = 8;

}  // namespace

LazStream::LazStream(std::unique_ptr<ByteSource> source, LazLayout layout, WantedFields plan, std::vector<Chunk> chunks,
                     unsigned threads)
    : source_(std::move(source)),
      layout_(std::move(layout)),
      plan_(std::move(plan)),
      chunks_(std::move(chunks)),
      threads_(std::min(threads, threads_max)) {}

Result<std::span<const std::byte>> LazStream::next(std::size_t most) {
  const bool at_begin_of_chunk = offset_ == 0 && decoded_ == 0;
  if (!pipeline_ && threads_ > 1 && most >= batch_points_max && at_begin_of_chunk && chunks_.size() > chunk_ + 1) {
    const auto left = std::span<const Chunk>(chunks_).subspan(chunk_);
    const auto useful = static_cast<unsigned>(std::min<std::size_t>(threads_, left.size()));
    pipeline_ = std::make_unique<ChunkPipeline>(*source_, layout_, plan_, left, useful);
    block_ = {};
    used_ = 0;
  }
  return pipeline_ ? from_pipeline(most) : from_decoder(most);
}

Result<std::span<const std::byte>> LazStream::from_pipeline(std::size_t most) {
  if (used_ == block_.records) {
    BOOST_OUTCOME_TRYV(pipeline_->next(block_));
    used_ = 0;
  }
  const std::size_t n = std::min(most, block_.records - used_);
  if (n == 0) {
    BOOST_OUTCOME_TRYV(source_->check_unchanged());
    return std::span<const std::byte>();
  }
  first_ = block_.first + used_;
  const std::size_t begin = used_ * plan_.record_bytes;
  used_ += n;
  return std::span<const std::byte>(block_.bytes).subspan(begin, n * plan_.record_bytes);
}

Result<std::span<const std::byte>> LazStream::from_decoder(std::size_t most) {
  if (chunk_ == chunks_.size()) {
    BOOST_OUTCOME_TRYV(source_->check_unchanged());
    return std::span<const std::byte>();
  }
  const Chunk& chunk = chunks_[chunk_];
  if (!decoder_ || offset_ < decoded_) {
    BOOST_OUTCOME_TRYV(bring_next());
    decoder_ = make_chunk_decoder(*source_, layout_, plan_, chunk);
    decoded_ = 0;
  }
  const std::size_t fitting = block_records(plan_.record_bytes);
  while (decoded_ < offset_) {
    BOOST_OUTCOME_TRYV(decode(static_cast<std::size_t>(std::min<std::uint64_t>(fitting, offset_ - decoded_))));
  }
  const auto n = static_cast<std::size_t>(std::min<std::uint64_t>({most, fitting, chunk.points - offset_}));
  BOOST_OUTCOME_TRYV(decode(n));
  first_ = chunk.first + offset_;
  offset_ += n;
  if (offset_ == chunk.points) {
    if (const auto end = decoder_->check_end(); end.has_error()) return chunk_error(*source_, chunk, end.error());
    decoder_.reset();
    ++chunk_;
    offset_ = decoded_ = 0;
  }
  return std::span<const std::byte>(block_.bytes).first(n * plan_.record_bytes);
}

// Fetches the next chunk of a far source, and more chunks the longer they are read without a seek.
Status LazStream::bring_next() {
  if (near_bytes_max(*source_) == 0 || chunk_ < brought_) return success();
  const auto left = std::span<const Chunk>(chunks_).subspan(chunk_);
  const auto next = left.first(chunks_at_once(*source_, left, ahead_));
  BOOST_OUTCOME_TRYV(bring_chunks(*source_, layout_, plan_, next));
  brought_ = chunk_ + next.size();
  ahead_ = std::min(2 * ahead_, chunks_ahead_max);
  return success();
}

Status LazStream::decode(std::size_t records) {
  if (block_.bytes.size() < records * plan_.record_bytes) block_.bytes.resize(records * plan_.record_bytes);
  const auto status = decoder_->decode(records, block_.bytes.data());
  if (status.has_error()) return chunk_error(*source_, chunks_[chunk_], status.error());
  decoded_ += records;
  return success();
}

void LazStream::seek(std::uint64_t record) {
  std::size_t chunk = 0;
  while (chunk < chunks_.size() && record >= chunks_[chunk].points) record -= chunks_[chunk++].points;
  if (pipeline_ || chunk != chunk_) {
    decoder_.reset();
    decoded_ = 0;
  }
  pipeline_.reset();
  brought_ = 0;
  ahead_ = 1;
  chunk_ = chunk;
  offset_ = chunk < chunks_.size() ? record : 0;
}

}  // namespace tessera::laz
