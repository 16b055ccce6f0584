#include "src/result/store/packed_tile.h"

#include <zlib.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "src/result/store/block_sum.h"
#include "src/result/store/packed_array.h"

namespace tessera::store {

namespace {

std::string place_of(const ArrayInfo& info) {
  switch (info.section) {
    case Section::points:
      return info.name;
    case Section::point_data:
      return "PointData/" + info.name;
    case Section::cells:
      return "Cells/" + info.name;
    case Section::cell_data:
      return "CellData/" + info.name;
  }
  return info.name;
}

std::uint64_t unpacked(const PackedTile::Packed& array, std::uint64_t block) {
  return std::min(block_bytes, array.bytes - block * block_bytes);
}

// Reads a plain block; false when it is not one. REQUIRES: the sizes fit together.
bool take_plain(std::span<const std::byte> from, std::span<std::byte> to) {
  const auto equal = [&](const auto& expected, std::size_t at) {
    return std::ranges::equal(expected, from.subspan(at, expected.size()));
  };
  if (!equal(plain_head(to.size()), 0)) return false;
  BlockChecksum sum;
  sum.copy(from.subspan(plain_head_bytes, to.size()), to.data());
  return equal(sum.bytes(), plain_head_bytes + to.size());
}

bool inflate_block(std::span<const std::byte> from, std::span<std::byte> to) {
  auto size = static_cast<uLongf>(to.size());
  auto used = static_cast<uLong>(from.size());
  return uncompress2(reinterpret_cast<Bytef*>(to.data()), &size, reinterpret_cast<const Bytef*>(from.data()), &used) ==
             Z_OK &&
         size == to.size() && used == from.size();
}

}  // namespace

Result<PackedTile> PackedTile::open(DataFile file, TileId tile) {
  PackedTile opened(std::move(file));
  BOOST_OUTCOME_TRYV(opened.read_header(tile));
  BOOST_OUTCOME_TRYV(opened.read_tables());
  return opened;
}

Error PackedTile::corrupt(const std::string& place, const std::string& reason) const {
  return error(Errc::corrupt, file_.path().string() + ", " + place + ": " + reason);
}

// Returns false when the file ends before.
Result<bool> PackedTile::read_at(std::uint64_t offset, std::span<std::byte> buffer) const {
  BOOST_OUTCOME_TRY(read, file_.read_up_to(offset, buffer));
  return read == buffer.size();
}

Status PackedTile::read_header(TileId tile) {
  std::string text;
  std::size_t end = std::string::npos;
  for (std::uint64_t wanted = 1 << 14; end == std::string::npos; wanted *= 4) {
    text.resize(std::min(wanted, file_.bytes()));
    BOOST_OUTCOME_TRY(whole, read_at(0, std::as_writable_bytes(std::span(text))));
    end = whole ? text.find(header_end) : std::string::npos;
    if (end == std::string::npos && (!whole || text.size() == file_.bytes() || text.find('\0') != std::string::npos))
      return corrupt("header", "is damaged, or not that of a tile file");
  }
  text.resize(end + header_end.size());
  auto header = parse_header(text);
  if (!header) return corrupt("header", "is damaged, or not that of a tile file");
  if (header->tile != tile) return corrupt("header", "is that of tile " + std::to_string(header->tile.value));
  constexpr std::uint64_t most = std::numeric_limits<std::int32_t>::max();
  const auto corners = static_cast<std::uint64_t>(header->dimension + 1);
  if (header->points > std::min(most, file_.bytes() / sizeof(Point)) ||
      header->cells > std::min(most, file_.bytes() / sizeof(std::int32_t)) / corners)
    return corrupt("header", "announces more points or cells than the file can hold");
  header_ = std::move(*header);
  data_begin_ = text.size();
  return success();
}

// Arrays may be anywhere between the header and the footer, which follows the last one. In format 2 they are end to
// end, in the header's order.
Status PackedTile::read_tables() {
  struct Extent {
    std::uint64_t begin, end;
  };
  std::vector<Extent> extents;
  const auto infos = header_.arrays();
  for (std::size_t i = 0; i < infos.size(); ++i) {
    Packed array{.info = infos[i], .bytes = header_.bytes_of(infos[i]), .sizes = {}};
    const auto damaged = [&] { return corrupt(place_of(array.info), "its table of blocks is damaged"); };
    const std::uint64_t blocks = block_count(array.bytes);
    if (header_.offsets[i] > file_.bytes() - data_begin_) return damaged();
    std::uint64_t at = data_begin_ + header_.offsets[i];
    array.table = at;
    if (table_bytes(blocks) > file_.bytes() - at) return damaged();
    std::vector<std::uint64_t> table(3 + blocks);
    BOOST_OUTCOME_TRY(whole, read_at(at, std::as_writable_bytes(std::span(table))));
    if (!whole || table[0] != blocks || table[1] != block_bytes || table[2] != array.bytes % block_bytes)
      return damaged();
    at += table_bytes(blocks);
    array.begin = at;
    array.sizes.assign(table.begin() + 3, table.end());
    for (std::uint64_t b = 0; b < blocks; ++b) {
      const bool fits = array.info.packing == Packing::plain
                            ? array.sizes[b] == unpacked(array, b) + plain_extra_bytes
                            : array.sizes[b] <= compressBound(static_cast<uLong>(block_bytes));
      if (!fits || array.sizes[b] > file_.bytes() - at) return damaged();
      at += array.sizes[b];
    }
    array.end = at;
    extents.push_back({array.table, array.end});
    arrays_.push_back(std::move(array));
  }
  if (header_.format > 2) std::ranges::sort(extents, {}, &Extent::begin);
  std::uint64_t at = data_begin_;
  for (const Extent& extent : extents) {
    if (header_.format > 2 ? extent.begin < at : extent.begin != at)
      return corrupt("header", "its arrays overlap or leave gaps");
    at = extent.end;
  }
  std::string end(footer.size(), '\0');
  BOOST_OUTCOME_TRY(whole, read_at(at, std::as_writable_bytes(std::span(end))));
  if (!whole || end != footer || at + footer.size() != file_.bytes())
    return corrupt("end", "is not where the arrays end");
  return success();
}

const PackedTile::Packed& PackedTile::find(Section section, std::string_view name) const {
  return *std::find_if(arrays_.begin(), arrays_.end(),
                       [&](const Packed& array) { return array.info.section == section && array.info.name == name; });
}

Status PackedTile::read_blocks(const Packed& array, std::span<std::byte> values) const {
  const auto damaged = [&](std::uint64_t block) {
    return corrupt(place_of(array.info), "block " + std::to_string(block) + " is damaged");
  };
  constexpr std::uint64_t at_once = 16;  // tables are read a megabyte at a time
  std::vector<std::byte> buffer;
  std::uint64_t at = array.begin;
  for (std::uint64_t first = 0; first < array.sizes.size(); first += at_once) {
    const std::uint64_t end = std::min<std::uint64_t>(first + at_once, array.sizes.size());
    std::uint64_t size = 0;
    for (std::uint64_t block = first; block < end; ++block) size += array.sizes[block];
    buffer.resize(size);
    BOOST_OUTCOME_TRY(whole, read_at(at, buffer));
    if (!whole) return damaged(first);
    at += size;
    std::span<const std::byte> rest = buffer;
    for (std::uint64_t block = first; block < end; ++block) {
      const auto to = values.subspan(block * block_bytes, unpacked(array, block));
      const auto from = rest.first(array.sizes[block]);
      if (!(array.info.packing == Packing::plain ? take_plain(from, to) : inflate_block(from, to)))
        return damaged(block);
      rest = rest.subspan(from.size());
    }
  }
  return success();
}

Status PackedTile::read_raw(const Packed& array, std::uint64_t offset, std::span<std::byte> buffer) const {
  BOOST_OUTCOME_TRY(whole, read_at(array.table + offset, buffer));
  if (!whole) return corrupt(place_of(array.info), "the file ends in it");
  return success();
}

}  // namespace tessera::store
