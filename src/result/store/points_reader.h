// Reads files of points. Nothing in a file is trusted: the head and each block have a checksum, memory is taken only
// for points and cells for which the file has blocks, and every value that other code relies on is checked.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "src/base/big_vector.h"
#include "src/base/result.h"
#include "src/result/store/column_block.h"
#include "src/result/store/data_file.h"
#include "src/result/store/points_file.h"
#include "src/result/store/points_head.h"
#include "src/result/store/points_tile.h"

namespace tessera::store {

// The bytes of a file, on disk or in memory.
class FileBytes {
 public:
  explicit FileBytes(DataFile file) : path_(file.path()), bytes_(file.bytes()), file_(std::move(file)) {}
  FileBytes(std::span<const std::byte> bytes, std::filesystem::path name)
      : path_(std::move(name)), memory_(bytes), bytes_(bytes.size()) {}

  const std::filesystem::path& path() const { return path_; }
  std::uint64_t bytes() const { return bytes_; }
  // The bytes at `offset`, valid until the next call. Fewer than asked for when the file ends before.
  Result<std::span<const std::byte>> at(std::uint64_t offset, std::uint64_t bytes);

 private:
  std::filesystem::path path_;
  std::span<const std::byte> memory_;
  std::uint64_t bytes_ = 0;
  std::optional<DataFile> file_;  // else in memory
  BigVector<std::byte> buffer_;
};

class PointsReader {
 public:
  // Reads the head.
  static Result<PointsReader> open(FileBytes file, TileId tile);

  const PointsHead& head() const { return head_; }
  Result<PointsTile> read(const PointsFields& fields);
  // Reads the ids of the own or of the foreign points, in the file's order.
  Result<std::vector<PointId>> read_ids(PointsColumn::Of of);
  // Passes on all blocks as they are stored, piece by piece. Nothing in them is checked.
  Status read_raw(const std::function<Status(std::span<const std::byte>)>& take);

 private:
  explicit PointsReader(FileBytes file) : file_(std::move(file)) {}
  Error corrupt(const std::string& place, const std::string& reason) const;
  Status read_head(TileId tile);
  Status read_points(const PointsFields& fields, PointsTile& tile);
  Status read_column(const PointsColumn& column, const ColumnBuffer& room);
  // `room` is the memory of the whole column.
  Status read_block(const PointsColumn& column, std::uint64_t block, const ColumnBuffer& room);
  Status check_values(const PointsTile& tile, PointsColumn::Of of, std::uint64_t block) const;

  FileBytes file_;
  PointsHead head_;
  std::vector<std::uint64_t> begins_;  // offsets of the blocks
  ColumnBlocks blocks_;
};

}  // namespace tessera::store
