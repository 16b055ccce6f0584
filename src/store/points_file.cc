// Reads files of points and writes them. Nothing in a file is believed: its head and each block carry a checksum,
// memory is taken only for points that the file has blocks for, and every value that others rely on is checked.
#include "src/store/points_file.h"

#include <fcntl.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "src/base/check.h"
#include "src/files/checksum.h"
#include "src/files/descriptor.h"
#include "src/store/column_block.h"

namespace tessera {

namespace fs = std::filesystem;
using namespace store;

namespace {

using What = PointsColumn::What;

// Where the values of a column are in memory.
template <class Byte, class Tile>
ColumnOf<Byte> place_in(Tile& tile, std::size_t stride_of_rows, const PointsColumn& column) {
  const std::size_t first = column.own ? 0 : tile.own;
  const auto at = [&](auto* values, std::size_t offset, std::size_t stride) {
    return ColumnOf<Byte>{column.type, reinterpret_cast<Byte*>(values) + first * stride + offset, stride, column.rows};
  };
  switch (column.what) {
    case What::x:
      return at(tile.points.data(), offsetof(Point, x), sizeof(Point));
    case What::y:
      return at(tile.points.data(), offsetof(Point, y), sizeof(Point));
    case What::z:
      return at(tile.points.data(), offsetof(Point, z), sizeof(Point));
    case What::id:
      return at(tile.ids.data(), 0, sizeof(PointId));
    case What::owner:
      return at(tile.owners.data(), 0, sizeof(TileId));
    case What::attribute:
      break;
  }
  std::size_t offset = 0;
  for (std::size_t i = 0; i < column.attribute; ++i) offset += size_of(tile.schema[i].type);
  return at(tile.rows.data(), offset, stride_of_rows);
}

bool is_negative_zero(double value) { return value == 0 && std::signbit(value); }

// The bytes of a file, on a disk or in memory.
class FileBytes {
 public:
  static Result<FileBytes> open(const fs::path& path) {
    FileBytes opened(path);
    BOOST_OUTCOME_TRY(file, open_handle(path, O_RDONLY));
    BOOST_OUTCOME_TRY(bytes, size_of(file, path));
    opened.file_ = std::move(file);
    opened.bytes_ = bytes;
    return opened;
  }
  FileBytes(std::span<const std::byte> bytes, fs::path name)
      : path_(std::move(name)), memory_(bytes), bytes_(bytes.size()) {}

  const fs::path& path() const { return path_; }
  std::uint64_t bytes() const { return bytes_; }
  // Until the next call. Fewer when the file ends before.
  Result<std::span<const std::byte>> at(std::uint64_t offset, std::uint64_t bytes) {
    if (file_.get() < 0) {
      const auto rest = memory_.subspan(std::min<std::uint64_t>(offset, memory_.size()));
      return rest.first(std::min<std::uint64_t>(bytes, rest.size()));
    }
    buffer_.resize(bytes);
    BOOST_OUTCOME_TRY(read, read_up_to(file_.get(), buffer_, offset, path_));
    return std::span<const std::byte>(buffer_).first(read);
  }

 private:
  explicit FileBytes(fs::path path) : path_(std::move(path)) {}

  fs::path path_;
  FileHandle file_;
  std::span<const std::byte> memory_;
  std::uint64_t bytes_ = 0;
  BigVector<std::byte> buffer_;
};

class PointsReader {
 public:
  static Result<PointsReader> open(FileBytes file, TileId tile) {
    PointsReader reader(std::move(file));
    BOOST_OUTCOME_TRYV(reader.read_head(tile));
    return reader;
  }

  const PointsHead& head() const { return head_; }

  Result<PointsTile> read(bool attributes) {
    PointsTile tile;
    tile.dimension = head_.dimension;
    tile.tile = head_.tile;
    tile.own = head_.own;
    tile.schema = head_.schema;
    const std::size_t n = head_.own + head_.foreign, stride = row_bytes(tile.schema);
    tile.points.resize(n);
    tile.ids.resize(n);
    tile.owners.resize(n, head_.tile);
    if (attributes) tile.rows.resize(n * stride);
    auto columns = head_.columns();
    if (!attributes) std::erase_if(columns, [](const PointsColumn& column) { return column.what == What::attribute; });
    for (const bool own : {true, false})
      for (std::uint64_t block = 0; block * block_rows < (own ? head_.own : head_.foreign); ++block) {
        // A block of each column before the next ones, for their values stand side by side.
        for (const PointsColumn& column : columns) {
          if (column.own != own) continue;
          BOOST_OUTCOME_TRYV(read_block(column, block, place_in<std::byte>(tile, stride, column)));
        }
        BOOST_OUTCOME_TRYV(check_values(tile, own, block));
      }
    return tile;
  }

  Result<std::vector<PointId>> read_own_ids() {
    std::vector<PointId> ids(head_.own);
    for (const PointsColumn& column : head_.columns()) {
      if (column.what != What::id || !column.own) continue;
      const ColumnRoom room{column.type, reinterpret_cast<std::byte*>(ids.data()), sizeof(PointId), ids.size()};
      for (std::uint64_t block = 0; block < column.blocks; ++block) {
        BOOST_OUTCOME_TRYV(read_block(column, block, room));
      }
    }
    return ids;
  }

 private:
  explicit PointsReader(FileBytes file) : file_(std::move(file)) {}

  Error corrupt(const std::string& place, const std::string& reason) const {
    return error(Errc::corrupt, file_.path().string() + ", " + place + ": " + reason);
  }

  Status read_head(TileId tile) {
    std::uint64_t wanted = 1 << 16;
    while (true) {
      BOOST_OUTCOME_TRY(bytes, file_.at(0, std::min(wanted, file_.bytes())));
      auto parsed = parse_points_head(bytes, file_.bytes());
      if (const auto* wrong = std::get_if<std::string>(&parsed)) return corrupt("head", *wrong);
      if (auto* head = std::get_if<PointsHead>(&parsed)) {
        head_ = std::move(*head);
        break;
      }
      if (bytes.size() < wanted) return corrupt("head", "ends too early");
      wanted = std::get<std::uint64_t>(parsed);
    }
    if (head_.tile != tile) return corrupt("head", "is that of tile " + to_string(head_.tile));
    std::uint64_t at = head_.bytes();
    for (const PointsHead::Block& block : head_.blocks) {
      begins_.push_back(at);
      at += block.bytes;
    }
    return success();
  }

  static std::uint64_t end_of(std::uint64_t block, std::uint64_t rows) {
    return std::min<std::uint64_t>((block + 1) * block_rows, rows);
  }

  // `room`: of the whole column.
  Status read_block(const PointsColumn& column, std::uint64_t block, const ColumnRoom& room) {
    const std::uint64_t number = column.first_block + block;
    const PointsHead::Block& entry = head_.blocks[number];
    BOOST_OUTCOME_TRY(bytes, file_.at(begins_[number], entry.bytes));
    const char* wrong = bytes.size() < entry.bytes ? "is cut off by the end of the file"
                        : checksum(bytes, number) != entry.xxh3
                            ? "is damaged"
                            : blocks_.take(bytes, room.part(block * block_rows, end_of(block, column.rows)));
    if (wrong != nullptr) return corrupt(head_.place(column) + ", block " + std::to_string(block), wrong);
    return success();
  }

  Status check_values(const PointsTile& tile, bool own, std::uint64_t block) const {
    const std::uint64_t first = own ? 0 : tile.own;
    const std::uint64_t end = first + end_of(block, own ? head_.own : head_.foreign);
    for (std::uint64_t i = first + block * block_rows; i < end; ++i) {
      const Point& p = tile.points[i];
      const char* wrong = !is_finite(p)                                                             ? " is not finite"
                          : is_negative_zero(p.x) || is_negative_zero(p.y) || is_negative_zero(p.z) ? " is at -0"
                          : !own && tile.owners[i] == tile.tile ? " is the tile's own, and stands among foreign ones"
                                                                : nullptr;
      if (wrong != nullptr) return corrupt("points", "point " + std::to_string(i) + wrong);
    }
    return success();
  }

  FileBytes file_;
  PointsHead head_;
  std::vector<std::uint64_t> begins_;  // of the blocks
  ColumnBlocks blocks_;
};

Result<PointsReader> open_points(const fs::path& path, TileId tile) {
  BOOST_OUTCOME_TRY(file, FileBytes::open(path));
  return PointsReader::open(std::move(file), tile);
}

}  // namespace

BigVector<std::byte> points_file_bytes(const PointsTileView& tile) {
  const std::size_t n = tile.points.size(), stride = row_bytes(tile.schema);
  check(n <= points_rows_max && tile.own <= n && tile.ids.size() == n && tile.owners.size() == n &&
            tile.rows.size() == n * stride,
        "a tile's points, ids, owners and rows are as many");
  PointsHead head{tile.dimension, tile.tile, tile.own, n - tile.own, tile.schema, {}};
  BigVector<std::byte> bytes(head.bytes());
  ColumnBlocks blocks;
  for (const PointsColumn& column : head.columns()) {
    const auto values = place_in<const std::byte>(tile, stride, column);
    for (std::size_t row = 0; row < column.rows; row += block_rows) {
      const std::size_t begin = bytes.size();
      blocks.append(values.part(row, std::min<std::size_t>(row + block_rows, column.rows)), bytes);
      const auto block = std::span(bytes).subspan(begin);
      head.blocks.push_back({static_cast<std::uint32_t>(block.size()), checksum(block, head.blocks.size())});
    }
  }
  write_points_head(head, std::span(bytes).first(head.bytes()));
  return bytes;
}

Result<PointsHead> read_points_head(const fs::path& path, TileId tile) {
  BOOST_OUTCOME_TRY(reader, open_points(path, tile));
  return reader.head();
}

Result<PointsTile> read_points_file(const fs::path& path, TileId tile, bool attributes) {
  BOOST_OUTCOME_TRY(reader, open_points(path, tile));
  return reader.read(attributes);
}

Result<std::vector<PointId>> read_own_point_ids(const fs::path& path, TileId tile) {
  BOOST_OUTCOME_TRY(reader, open_points(path, tile));
  return reader.read_own_ids();
}

Result<PointsTile> parse_points_file(std::span<const std::byte> bytes, const fs::path& name, TileId tile,
                                     bool attributes) {
  BOOST_OUTCOME_TRY(reader, PointsReader::open(FileBytes(bytes, name), tile));
  return reader.read(attributes);
}

}  // namespace tessera
