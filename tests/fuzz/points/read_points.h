// What the fuzz target does with its bytes, and the replay test with those of earlier runs: they are a file of points,
// once as they are and once with checksums that are right, for no fuzzer finds these; and they are a block of a column.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <span>
#include <variant>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/big_vector.h"
#include "src/base/files/checksum.h"
#include "src/base/point.h"
#include "src/result/store/column_block.h"
#include "src/result/store/points_file.h"

namespace tessera {

inline void must_hold(bool holds) {
  if (!holds) std::abort();
}

template <class List>
bool same_bytes(const List& a, const List& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0);
}

// A tile that keeps what is promised of those that are read, and that can be written and read again; or a sentence.
inline void read_points(std::span<const std::byte> bytes, TileId number) {
  const auto read = parse_points_file(bytes, "stranger.pts", number);
  if (read.has_error()) {
    must_hold(read.error().code == Errc::corrupt && read.error().where.starts_with("stranger.pts, "));
    return;
  }
  const PointsTile& tile = read.value();
  const std::size_t n = tile.points.size();
  must_hold(tile.tile == number && tile.own <= n && tile.ids.size() == n && tile.owners.size() == n);
  must_hold(tile.rows.size() == n * row_bytes(tile.schema));
  must_hold(tile.cell_columns.size() == tile.cell_schema.size());
  for (std::size_t c = 0; c < tile.cell_columns.size(); ++c)
    must_hold(tile.cell_columns[c].size() == tile.cells * size_of(tile.cell_schema[c].type));
  for (std::size_t i = 0; i < n; ++i) {
    must_hold(is_finite(tile.points[i]) && (tile.dimension == 3 || tile.points[i].z == 0));
    must_hold((tile.owners[i] == number) == (i < tile.own));
  }
  if (n > 100'000) return;  // takes its time
  const auto again = parse_points_file(points_file_bytes(view_of(tile)), "again.pts", number);
  must_hold(again.has_value() && again.value().own == tile.own && again.value().cells == tile.cells &&
            again.value().schema == tile.schema);
  must_hold(same_bytes(again.value().points, tile.points) && same_bytes(again.value().ids, tile.ids));
  must_hold(same_bytes(again.value().owners, tile.owners) && same_bytes(again.value().rows, tile.rows));
}

// The sums that bytes which look like a file should have.
inline void set_sums(std::span<std::byte> bytes) {
  constexpr std::size_t head_bytes_at = 17, sum_bytes = 8, entry_bytes = 12;
  if (bytes.size() < head_bytes_at + 4) return;
  std::uint32_t head_bytes = 0;
  std::memcpy(&head_bytes, &bytes[head_bytes_at], sizeof head_bytes);
  if (head_bytes < head_bytes_at + 4 + sum_bytes || head_bytes > bytes.size()) return;
  const auto seal = [&] {
    const std::uint64_t sum = checksum(bytes.first(head_bytes - sum_bytes));
    std::memcpy(&bytes[head_bytes - sum_bytes], &sum, sum_bytes);
  };
  seal();
  const auto parsed = store::parse_points_head(bytes, bytes.size());
  const auto* head = std::get_if<store::PointsHead>(&parsed);
  if (head == nullptr) return;
  std::byte* entry = bytes.data() + head_bytes - sum_bytes - head->blocks.size() * entry_bytes;
  std::size_t begin = head_bytes;
  for (std::size_t i = 0; i < head->blocks.size(); ++i, entry += entry_bytes) {
    const std::uint64_t sum = checksum(bytes.subspan(begin, head->blocks[i].bytes), i);
    std::memcpy(entry + 4, &sum, sizeof sum);
    begin += head->blocks[i].bytes;
  }
  seal();
}

// Its type and number of rows stand before it.
inline void read_block(std::span<const std::byte> bytes) {
  if (bytes.size() < 3) return;
  const auto type = static_cast<AttributeType>(std::to_integer<unsigned>(bytes[0]) % 10);
  const std::size_t rows = (std::to_integer<std::size_t>(bytes[1]) << 8u | std::to_integer<std::size_t>(bytes[2])) + 1;
  const std::size_t size = size_of(type);
  std::vector<std::byte> values(std::min(rows, store::block_rows) * size), again(values.size());
  const auto room = [&](std::vector<std::byte>& at) {
    return store::ColumnBuffer{type, at.data(), size, at.size() / size};
  };
  store::ColumnBlocks blocks;
  if (blocks.take(bytes.subspan(3), room(values)) != nullptr) return;
  BigVector<std::byte> written;
  blocks.append({type, values.data(), size, values.size() / size}, written);
  must_hold(blocks.take(written, room(again)) == nullptr && again == values);
}

inline void read_stranger_points(std::span<const std::byte> bytes) {
  std::uint32_t tile = 0;  // as the file has it
  if (bytes.size() >= 29) std::memcpy(&tile, &bytes[25], sizeof tile);
  read_points(bytes, TileId{tile});
  std::vector<std::byte> sealed(bytes.begin(), bytes.end());
  set_sums(sealed);
  read_points(sealed, TileId{tile});
  read_block(bytes);
}

}  // namespace tessera
