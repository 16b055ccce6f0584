#include "src/result/store/packed_array.h"

#define ZLIB_CONST
#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <mutex>
#include <utility>

#include "src/base/check.h"
#include "src/base/stopped.h"
#include "src/result/store/block_sum.h"
#include "src/result/store/deflate_runs.h"

namespace tessera::store {

namespace {

using Bytes = std::vector<std::byte>;

// One deflater a thread: setting up zlib's quarter of a megabyte takes longer than deflating the arrays of a small
// tile.
class Deflater {
 public:
  Deflater() {
    if (deflateInit(&stream_, 1) != Z_OK) throw std::bad_alloc();
  }
  Deflater(const Deflater&) = delete;
  Deflater& operator=(const Deflater&) = delete;
  ~Deflater() { deflateEnd(&stream_); }

  Bytes deflate_all(std::span<const std::byte> bytes) {
    check(deflateReset(&stream_) == Z_OK, "a stream can be used again");
    Bytes packed(deflateBound(&stream_, static_cast<uLong>(bytes.size())));
    stream_.next_in = reinterpret_cast<const Bytef*>(bytes.data());
    stream_.avail_in = static_cast<uInt>(bytes.size());
    stream_.next_out = reinterpret_cast<Bytef*>(packed.data());
    stream_.avail_out = static_cast<uInt>(packed.size());
    check(deflate(&stream_, Z_FINISH) == Z_STREAM_END, "zlib needs more room than it asked for");
    packed.resize(stream_.total_out);
    packed.shrink_to_fit();
    return packed;
  }

 private:
  z_stream stream_{};
};

Bytes deflate_block(std::span<const std::byte> bytes) {
  thread_local Deflater deflater;
  return deflater.deflate_all(bytes);
}

// Writes `bytes` bytes, which come in any pieces, as blocks.
class PlainBlocks {
 public:
  PlainBlocks(std::uint64_t bytes, DirectWriter& file) : left_(bytes), file_(file) {}

  Status add(std::span<const std::byte> bytes) {
    if (bytes.size() > left_ + (block_ - done_)) return error(Errc::internal, "an array is longer than its table says");
    while (!bytes.empty()) {
      if (done_ == block_) {
        block_ = std::min(left_, block_bytes);
        left_ -= block_;
        done_ = 0;
        sum_ = {};
        BOOST_OUTCOME_TRYV(file_.append(plain_head(block_)));
      }
      const auto piece = bytes.first(std::min<std::uint64_t>(bytes.size(), block_ - done_));
      BOOST_OUTCOME_TRYV(file_.append(piece, sum_));
      done_ += piece.size();
      bytes = bytes.subspan(piece.size());
      if (done_ == block_) {
        BOOST_OUTCOME_TRYV(file_.append(sum_.bytes()));
      }
    }
    return success();
  }

  Status finish() const {
    return left_ == 0 && done_ == block_ ? Status(success())
                                         : error(Errc::internal, "an array is shorter than its table says");
  }

 private:
  std::uint64_t left_;  // after the current block
  std::uint64_t block_ = 0, done_ = 0;
  BlockChecksum sum_;
  DirectWriter& file_;
};

Bytes offsets_block(std::uint64_t first, std::uint64_t count, int step) {
  std::vector<std::int32_t> values(count);
  for (std::uint64_t i = 0; i < count; ++i)
    values[i] = static_cast<std::int32_t>((first + i + 1) * static_cast<std::uint64_t>(step));
  return deflate_block(std::as_bytes(std::span(values)));
}

}  // namespace

PackedArray PackedArray::plain(std::span<const std::byte> bytes) {
  return streamed(bytes.size(), [bytes](const Consumer& take) { return take(bytes); });
}

PackedArray PackedArray::streamed(std::uint64_t bytes, Make make, std::uint64_t written) {
  PackedArray array;
  array.written_ = written;
  array.bytes_ = bytes;
  array.make_ = std::move(make);
  return array;
}

PackedArray PackedArray::runs(std::span<const std::byte> bytes, std::size_t size) {
  PackedArray array;
  array.bytes_ = bytes.size();
  for (; !bytes.empty(); bytes = bytes.subspan(std::min(bytes.size(), block_bytes)))
    array.blocks_.push_back(
        std::make_shared<const Bytes>(deflate_runs(bytes.first(std::min(bytes.size(), block_bytes)), size)));
  return array;
}

PackedArray PackedArray::repeated(std::span<const std::byte> value, std::uint64_t count) {
  PackedArray array;
  array.bytes_ = count * value.size();
  Bytes bytes(std::min(array.bytes_, block_bytes));
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = value[i % value.size()];
  if (const auto whole = array.bytes_ / block_bytes; whole > 0)
    array.blocks_.assign(whole, std::make_shared<const Bytes>(deflate_runs(bytes, value.size())));
  if (const auto rest = array.bytes_ % block_bytes; rest > 0)
    array.blocks_.push_back(std::make_shared<const Bytes>(deflate_runs(std::span(bytes).first(rest), value.size())));
  return array;
}

PackedArray PackedArray::offsets(std::uint64_t cells, int step, const std::stop_token& stop) {
  constexpr std::uint64_t entries = block_bytes / 4;
  constexpr std::uint64_t kept_blocks = 1024;  // 16.8 million cells: 18 MB at most, which large tiles use entirely
  static std::mutex mutex;
  static std::map<std::pair<std::uint64_t, int>, Block> kept;
  PackedArray array;
  array.bytes_ = 4 * cells;
  for (std::uint64_t first = 0; first < cells; first += entries) {
    throw_if_stopped(stop);
    const std::pair key(first, step);
    const bool keep = cells - first >= entries && first < kept_blocks * entries;
    if (keep) {
      const std::lock_guard lock(mutex);
      if (const auto found = kept.find(key); found != kept.end()) {
        array.blocks_.push_back(found->second);
        continue;
      }
    }
    // Made outside the lock: two threads may both make the block, and one copy is dropped.
    auto made = std::make_shared<const Bytes>(offsets_block(first, std::min(entries, cells - first), step));
    if (keep) {
      const std::lock_guard lock(mutex);
      kept.try_emplace(key, made);
    }
    array.blocks_.push_back(std::move(made));
  }
  return array;
}

std::uint64_t PackedArray::file_bytes() const {
  const std::uint64_t blocks = block_count(bytes_);
  std::uint64_t size = table_bytes(blocks) + (blocks_.empty() ? plain_bytes(bytes_) : 0);
  for (const auto& block : blocks_) size += block->size();
  return size;
}

Status PackedArray::write(DirectWriter& file, std::uint64_t offset) const {
  const std::uint64_t blocks = block_count(bytes_);
  std::vector<std::uint64_t> table{blocks, block_bytes, bytes_ % block_bytes};
  for (const auto& block : blocks_) table.push_back(block->size());
  for (std::uint64_t left = bytes_; blocks_.empty() && left > 0; left -= std::min(left, block_bytes))
    table.push_back(std::min(left, block_bytes) + plain_extra_bytes);
  BOOST_OUTCOME_TRYV(file.skip_to(offset));
  BOOST_OUTCOME_TRYV(file.append(std::as_bytes(std::span(table))));
  for (const auto& block : blocks_) {
    BOOST_OUTCOME_TRYV(file.append(*block));
  }
  if (!make_) return success();
  if (written_ > 0) {
    BOOST_OUTCOME_TRYV(file.skip_to(offset + table_bytes(blocks) + plain_bytes(written_)));
  }
  return write_plain(bytes_ - written_, make_, file);
}

Status write_plain(std::uint64_t bytes, const PackedArray::Make& make, DirectWriter& file) {
  PlainBlocks plain(bytes, file);
  BOOST_OUTCOME_TRYV(make([&](std::span<const std::byte> piece) { return plain.add(piece); }));
  return plain.finish();
}

}  // namespace tessera::store
