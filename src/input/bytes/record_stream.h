// Records of equal length that follow each other: the body of LAS, NumPy and most binary PLY files.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"

namespace tessera {

// The most points, and the most bytes, that readers give in one batch.
inline constexpr std::size_t batch_points_max = 65'536;
inline constexpr std::size_t block_bytes_max = std::size_t{4} << 20;
// The number of points to read at once when `most` are asked for. Fewer for rows of thousands of columns.
inline std::size_t points_at_once(std::size_t most, std::size_t row_bytes) {
  return std::min(
      {most, batch_points_max, std::max<std::size_t>(1, block_bytes_max / std::max<std::size_t>(1, row_bytes))});
}

// Records like those of LAS files, whatever they come from.
class RecordSource {
 public:
  virtual ~RecordSource() = default;
  // The next records, at most `most` and about 4 MiB. They are valid until the next call. Empty at the end.
  virtual Result<std::span<const std::byte>> next(std::size_t most) = 0;
  virtual void seek(std::uint64_t record) = 0;
  virtual std::size_t record_bytes() const = 0;
  // The number, in the file, of the first record that next() returned last.
  virtual std::uint64_t first_of_last_block() const = 0;
};

// Records of equal length in a source, from `offset` on.
class RecordStream : public RecordSource {
 public:
  RecordStream(std::unique_ptr<ByteSource> source, std::uint64_t offset, std::size_t record_bytes, std::uint64_t count)
      : source_(std::move(source)), offset_(offset), record_bytes_(record_bytes), count_(count) {}

  // The error "path, record 812: ..." if the file has fewer than `count` records. The record is the first one missing.
  Status check_size() const;

  Result<std::span<const std::byte>> next(std::size_t most) override;
  void seek(std::uint64_t record) override { position_ = record < count_ ? record : count_; }
  std::size_t record_bytes() const override { return record_bytes_; }
  std::uint64_t first_of_last_block() const override { return first_; }

  const ByteSource& source() const { return *source_; }

 private:
  std::unique_ptr<ByteSource> source_;
  std::uint64_t offset_;
  std::size_t record_bytes_;
  std::uint64_t count_;
  std::uint64_t position_ = 0;
  std::uint64_t first_ = 0;
  std::vector<std::byte> block_;
};

}  // namespace tessera
