// Reads a tile file back. Nothing in it is believed: the header must be one that this program writes, arrays must
// not overlap, memory is taken only for what the file is large enough to hold, every block carries a checksum, and
// every value that others will use as an index is checked.
#include <fcntl.h>
#include <sys/stat.h>
#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>

#include "src/files/descriptor.h"
#include "src/files/names.h"
#include "src/store/block_sum.h"
#include "src/store/mesh_checks.h"
#include "src/store/packed_array.h"
#include "src/store/tile_layout.h"
#include "src/store/tile_store.h"
#include "src/store/vtk_xml.h"

namespace tessera {

namespace fs = std::filesystem;
using namespace store;

namespace {

class TileReader {
 public:
  TileReader(fs::path path, TileId tile) : path_(std::move(path)), tile_(tile) {}

  Result<StoredTile> read(bool with_cells, bool with_rows) {
    BOOST_OUTCOME_TRYV(open());
    BOOST_OUTCOME_TRYV(read_header());
    BOOST_OUTCOME_TRYV(read_tables());
    StoredTile stored;
    TileMesh& mesh = stored.mesh;
    mesh.dimension = header_.dimension;
    stored.schema = header_.schema;
    BOOST_OUTCOME_TRYV(read_array(Section::points, "Points", mesh.points));
    BOOST_OUTCOME_TRYV(read_array(Section::point_data, "id", mesh.ids));
    BOOST_OUTCOME_TRYV(read_array(Section::point_data, "owner", mesh.owners));
    BOOST_OUTCOME_TRYV(read_array(Section::point_data, "vtkGhostType", mesh.point_ghost));
    if (with_cells) {
      BOOST_OUTCOME_TRYV(read_array(Section::cells, "connectivity", mesh.cells));
      BOOST_OUTCOME_TRYV(read_array(Section::cell_data, "vtkGhostType", mesh.cell_ghost));
      if (header_.final) {
        BOOST_OUTCOME_TRYV(read_array(Section::cell_data, "final", mesh.cell_final));
      }
      if (header_.neighbors) {
        BOOST_OUTCOME_TRYV(read_array(Section::cell_data, "neighbors", mesh.neighbors));
      }
      BOOST_OUTCOME_TRYV(check_constant_arrays());
    }
    BOOST_OUTCOME_TRYV(check_values(
        mesh, [this](const std::string& place, const std::string& reason) { return corrupt(place, reason); }));
    for (std::size_t i = 0; i < mesh.owners.size(); ++i)
      if ((mesh.owners[i] != tile_) != (mesh.point_ghost[i] != 0))
        return corrupt("PointData/owner", "point " + std::to_string(i) + " of tile " + to_string(mesh.owners[i]) +
                                              " has the wrong vtkGhostType");
    if (with_rows) {
      BOOST_OUTCOME_TRYV(read_rows(stored));
    }
    return stored;
  }

  Result<std::vector<PointId>> read_own_ids() {
    BOOST_OUTCOME_TRYV(open());
    BOOST_OUTCOME_TRYV(read_header());
    BOOST_OUTCOME_TRYV(read_tables());
    std::vector<PointId> ids;
    std::vector<std::uint8_t> ghost;
    BOOST_OUTCOME_TRYV(read_array(Section::point_data, "id", ids));
    BOOST_OUTCOME_TRYV(read_array(Section::point_data, "vtkGhostType", ghost));
    return own_of(std::move(ids), ghost);
  }

  static std::vector<PointId> own_of(std::vector<PointId> ids, const std::vector<std::uint8_t>& ghost) {
    std::size_t own = 0;
    for (std::size_t i = 0; i < ids.size(); ++i)
      if (ghost[i] == 0) ids[own++] = ids[i];
    ids.resize(own);
    return ids;
  }

 private:
  // An array in the file.
  struct Packed {
    ArrayInfo info;
    std::uint64_t bytes = 0;           // unpacked
    std::uint64_t begin = 0;           // of the first block
    std::vector<std::uint64_t> sizes;  // of the blocks
  };

  Error corrupt(const std::string& place, const std::string& reason) const {
    return error(Errc::corrupt, path_.string() + ", " + place + ": " + reason);
  }

  static std::string place_of(const ArrayInfo& info) {
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

  Status open() {
    BOOST_OUTCOME_TRY(file, open_handle(path_, O_RDONLY));
    BOOST_OUTCOME_TRY(bytes, size_of(file, path_));
    file_ = std::move(file);
    bytes_ = bytes;
    return success();
  }

  // False when the file ends before.
  Result<bool> read_at(std::uint64_t offset, std::span<std::byte> buffer) const {
    BOOST_OUTCOME_TRY(read, read_up_to(file_.get(), buffer, offset, path_));
    return read == buffer.size();
  }

  Status read_header() {
    std::string text;
    std::size_t end = std::string::npos;
    for (std::uint64_t wanted = 1 << 14; end == std::string::npos; wanted *= 4) {
      text.resize(std::min(wanted, bytes_));
      BOOST_OUTCOME_TRY(whole, read_at(0, std::as_writable_bytes(std::span(text))));
      end = whole ? text.find(header_end) : std::string::npos;
      if (end == std::string::npos && (!whole || text.size() == bytes_ || text.find('\0') != std::string::npos))
        return corrupt("header", "is not that of a tile file, or damaged");
    }
    text.resize(end + header_end.size());
    auto header = parse_header(text);
    if (!header) return corrupt("header", "is not that of a tile file, or damaged");
    if (header->tile != tile_) return corrupt("header", "is that of tile " + std::to_string(header->tile.value));
    constexpr std::uint64_t most = std::numeric_limits<std::int32_t>::max();
    const auto corners = static_cast<std::uint64_t>(header->dimension + 1);
    if (header->points > std::min(most, bytes_ / sizeof(Point)) ||
        header->cells > std::min(most, bytes_ / sizeof(std::int32_t)) / corners)
      return corrupt("header", "tells of more than the file can hold");
    header_ = std::move(*header);
    data_begin_ = text.size();
    return success();
  }

  // Arrays stand anywhere between the header and the footer, which follows the last one; in format 2 end to end, in the
  // header's order.
  Status read_tables() {
    struct Extent {
      std::uint64_t begin, end;
    };
    std::vector<Extent> extents;
    const auto infos = header_.arrays();
    for (std::size_t i = 0; i < infos.size(); ++i) {
      Packed array{infos[i], header_.bytes_of(infos[i]), 0, {}};
      const auto damaged = [&] { return corrupt(place_of(array.info), "its table of blocks is damaged"); };
      const std::uint64_t blocks = block_count(array.bytes);
      if (header_.offsets[i] > bytes_ - data_begin_) return damaged();
      std::uint64_t at = data_begin_ + header_.offsets[i];
      extents.push_back({at, at});
      if (table_bytes(blocks) > bytes_ - at) return damaged();
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
        if (!fits || array.sizes[b] > bytes_ - at) return damaged();
        at += array.sizes[b];
      }
      extents.back().end = at;
      arrays_.push_back(std::move(array));
    }
    if (header_.format > 2) std::ranges::sort(extents, {}, &Extent::begin);
    std::uint64_t at = data_begin_;
    for (const Extent& extent : extents) {
      if (header_.format > 2 ? extent.begin < at : extent.begin != at)
        return corrupt("header", "its arrays are not where they can be");
      at = extent.end;
    }
    std::string end(footer.size(), '\0');
    BOOST_OUTCOME_TRY(whole, read_at(at, std::as_writable_bytes(std::span(end))));
    if (!whole || end != footer || at + footer.size() != bytes_) return corrupt("end", "is not where the arrays end");
    return success();
  }

  static std::uint64_t unpacked(const Packed& array, std::uint64_t block) {
    return std::min(block_bytes, array.bytes - block * block_bytes);
  }

  const Packed& find(Section section, std::string_view name) const {
    return *std::find_if(arrays_.begin(), arrays_.end(),
                         [&](const Packed& array) { return array.info.section == section && array.info.name == name; });
  }

  // REQUIRES: every tile has the array.
  template <class List>
  Status read_array(Section section, std::string_view name, List& values) const {
    return read_array(find(section, name), values);
  }

  template <class List>
  Status read_array(const Packed& array, List& values) const {
    values.resize(array.bytes / sizeof(typename List::value_type));
    return read_blocks(array, std::as_writable_bytes(std::span(values)));
  }

  Status read_blocks(const Packed& array, std::span<std::byte> values) const {
    const auto damaged = [&](std::uint64_t block) {
      return corrupt(place_of(array.info), "block " + std::to_string(block) + " is damaged");
    };
    constexpr std::uint64_t at_once = 16;  // a megabyte a call
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

  // REQUIRES: sizes fit together.
  static bool take_plain(std::span<const std::byte> from, std::span<std::byte> to) {
    const auto equal = [&](const auto& expected, std::size_t at) {
      return std::ranges::equal(expected, from.subspan(at, expected.size()));
    };
    if (!equal(plain_head(to.size()), 0)) return false;
    BlockSum sum;
    sum.copy(from.subspan(plain_head_bytes, to.size()), to.data());
    return equal(sum.bytes(), plain_head_bytes + to.size());
  }

  static bool inflate_block(std::span<const std::byte> from, std::span<std::byte> to) {
    auto size = static_cast<uLongf>(to.size());
    auto used = static_cast<uLong>(from.size());
    return uncompress2(reinterpret_cast<Bytef*>(to.data()), &size, reinterpret_cast<const Bytef*>(from.data()),
                       &used) == Z_OK &&
           size == to.size() && used == from.size();
  }

  Status check_constant_arrays() const {
    const auto corners = static_cast<std::uint64_t>(header_.dimension + 1);
    std::vector<std::uint8_t> types;
    BOOST_OUTCOME_TRYV(read_array(Section::cells, "types", types));
    for (std::size_t i = 0; i < types.size(); ++i)
      if (types[i] != vtk_cell_type(header_.dimension))
        return corrupt("Cells/types", "cell " + std::to_string(i) + " is of another type");
    std::vector<std::int32_t> numbers;
    BOOST_OUTCOME_TRYV(read_array(Section::cells, "offsets", numbers));
    for (std::size_t i = 0; i < numbers.size(); ++i)
      if (numbers[i] < 0 || static_cast<std::uint64_t>(numbers[i]) != (i + 1) * corners)
        return corrupt("Cells/offsets", "entry " + std::to_string(i) + " is not " + std::to_string((i + 1) * corners));
    BOOST_OUTCOME_TRYV(read_array(Section::cell_data, "tile", numbers));
    for (std::size_t i = 0; i < numbers.size(); ++i)
      if (static_cast<std::uint32_t>(numbers[i]) != tile_.value)
        return corrupt("CellData/tile", "cell " + std::to_string(i) + " is of another tile");
    return success();
  }

  Status read_rows(StoredTile& stored) const {
    const std::size_t stride = row_bytes(stored.schema), n = header_.points;
    stored.rows.resize(n * stride);
    std::size_t offset = 0;
    std::vector<std::byte> column;
    for (std::size_t k = 0; k < stored.schema.size(); ++k) {
      const std::size_t size = size_of(stored.schema[k].type);
      BOOST_OUTCOME_TRYV(read_array(arrays_[first_attribute + k], column));
      for (std::size_t i = 0; i < n; ++i)
        std::memcpy(stored.rows.data() + i * stride + offset, column.data() + i * size, size);
      offset += size;
    }
    return success();
  }

  fs::path path_;
  TileId tile_;
  FileHandle file_;
  std::uint64_t bytes_ = 0;
  TileHeader header_;
  std::uint64_t data_begin_ = 0;
  std::vector<Packed> arrays_;
};

}  // namespace

Result<StoredTile> read_tile(const fs::path& out, TileId tile, bool with_rows) {
  return TileReader(tile_file(out, tile), tile).read(true, with_rows);
}

Result<StoredTile> read_tile_vertices(const fs::path& out, TileId tile, bool with_rows) {
  return TileReader(tile_file(out, tile), tile).read(false, with_rows);
}

Result<std::vector<PointId>> read_own_ids(const fs::path& out, TileId tile) {
  return TileReader(tile_file(out, tile), tile).read_own_ids();
}

}  // namespace tessera
