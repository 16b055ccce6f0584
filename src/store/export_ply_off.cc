// PLY (binary little endian) and OFF (text): all vertices, then all cells.
#include <limits>

#include "src/store/export_common.h"

namespace tessera::store {

namespace fs = std::filesystem;

namespace {

const char* ply_type(AttributeType type) {
  switch (type) {
    case AttributeType::u8:
      return "uchar";
    case AttributeType::i8:
      return "char";
    case AttributeType::u16:
      return "ushort";
    case AttributeType::i16:
      return "short";
    case AttributeType::u32:
      return "uint";
    case AttributeType::i32:
      return "int";
    case AttributeType::f32:
      return "float";
    case AttributeType::u64:  // PLY has no 64-bit integers; a double holds them up to 2^53
    case AttributeType::i64:
    case AttributeType::f64:
      return "double";
  }
  return "";
}

void write_attribute(Stream& stream, AttributeType type, const std::byte* from) {
  if (type == AttributeType::u64) {
    std::uint64_t value;
    std::memcpy(&value, from, 8);
    stream.value(static_cast<double>(value));
  } else if (type == AttributeType::i64) {
    std::int64_t value;
    std::memcpy(&value, from, 8);
    stream.value(static_cast<double>(value));
  } else {
    stream.bytes({from, size_of(type)});
  }
}

std::string ply_name(std::string name) {
  for (char& c : name)
    if (c <= ' ' || c == '\x7f') c = '_';  // names end at white space
  return name;
}

std::string ply_header(const Manifest& manifest) {
  std::string header = "ply\nformat binary_little_endian 1.0\ncomment tessera " + ply_name(manifest.software_version) +
                       "\nelement vertex " + std::to_string(manifest.vertices) +
                       "\nproperty double x\nproperty double y\nproperty double z\n";
  for (const auto& attribute : manifest.schema)
    header += std::string("property ") + ply_type(attribute.type) + " " + ply_name(attribute.name) + "\n";
  header += std::string("element ") + (manifest.dimension == 2 ? "face " : "cell ") + std::to_string(manifest.cells) +
            "\nproperty list uchar uint vertex_indices\nend_header\n";
  return header;
}

// Both formats: `write_vertex(stream, point, row)` for every vertex, `write_cell(stream, numbers)` for every main cell.
template <class WriteVertex, class WriteCell>
Result<Exported> export_list(const fs::path& out, const Manifest& manifest, const fs::path& target,
                             const std::string& header, bool with_rows, std::stop_token stop, WriteVertex write_vertex,
                             WriteCell write_cell) {
  if (manifest.vertices > std::numeric_limits<std::uint32_t>::max())
    return error(Errc::usage, target.string() + ": the format numbers 2^32 vertices at most: use vtu");
  BOOST_OUTCOME_TRY(file, OutputFile::create(target));
  Stream stream(file, 0);
  stream.text(header);
  const std::size_t stride = row_bytes(manifest.schema);
  BOOST_OUTCOME_TRY(
      numbers, VertexNumbers::assign(out, manifest, with_rows, stop, [&](const StoredTile& tile) -> Status {
        if (with_rows && tile.schema != manifest.schema)
          return error(Errc::corrupt, out.string() + ": a tile has other attributes than the manifest");
        for (std::size_t i = 0; i < tile.mesh.points.size(); ++i)
          if (tile.mesh.point_ghost[i] == 0)
            write_vertex(stream, tile.mesh.points[i], with_rows ? tile.rows.data() + i * stride : nullptr);
        return success();
      }));
  Exported exported;
  exported.vertices = numbers.vertices();
  const std::size_t corners = static_cast<std::size_t>(manifest.dimension) + 1;
  const auto write_cells = [&](const StoredTile& tile, std::size_t index) -> Status {
    BOOST_OUTCOME_TRY(of, numbers.of(tile.mesh, index, tile_file(out, TileId{manifest.tiles[index].tile})));
    std::uint32_t cell[4];
    for (std::size_t i = 0; i < tile.mesh.cell_ghost.size(); ++i) {
      if (tile.mesh.cell_ghost[i] != 0) continue;
      for (std::size_t k = 0; k < corners; ++k)
        cell[k] = static_cast<std::uint32_t>(of[static_cast<std::size_t>(tile.mesh.cells[i * corners + k])]);
      write_cell(stream, std::span<const std::uint32_t>(cell, corners));
      ++exported.cells;
    }
    return success();
  };
  BOOST_OUTCOME_TRYV(for_each_tile(out, manifest, false, stop, write_cells));
  BOOST_OUTCOME_TRYV(stream.flush());
  BOOST_OUTCOME_TRYV(check_counts(out, manifest, exported));
  BOOST_OUTCOME_TRY(bytes, file.finish());
  exported.bytes = bytes;
  return exported;
}

}  // namespace

Result<Exported> export_ply(const fs::path& out, const Manifest& manifest, const fs::path& target,
                            std::stop_token stop) {
  const auto vertex = [&](Stream& stream, const Point& p, const std::byte* row) {
    stream.value(p);
    for (const auto& attribute : manifest.schema) {
      write_attribute(stream, attribute.type, row);
      row += size_of(attribute.type);
    }
  };
  const auto cell = [](Stream& stream, std::span<const std::uint32_t> numbers) {
    stream.value(static_cast<std::uint8_t>(numbers.size()));
    stream.bytes(std::as_bytes(numbers));
  };
  return export_list(out, manifest, target, ply_header(manifest), true, stop, vertex, cell);
}

Result<Exported> export_off(const fs::path& out, const Manifest& manifest, const fs::path& target,
                            std::stop_token stop) {
  const auto vertex = [](Stream& stream, const Point& p, const std::byte*) {
    stream.digits(p.x);
    stream.text(" ");
    stream.digits(p.y);
    stream.text(" ");
    stream.digits(p.z);
    stream.text("\n");
  };
  const auto cell = [](Stream& stream, std::span<const std::uint32_t> numbers) {
    stream.digits(numbers.size());
    for (const auto number : numbers) {
      stream.text(" ");
      stream.digits(number);
    }
    stream.text("\n");
  };
  const std::string header =
      "OFF\n" + std::to_string(manifest.vertices) + " " + std::to_string(manifest.cells) + " 0\n";
  return export_list(out, manifest, target, header, false, stop, vertex, cell);
}

}  // namespace tessera::store
