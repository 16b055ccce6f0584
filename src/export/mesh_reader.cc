#include "src/export/mesh_reader.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <vector>

#include "src/base/option.h"
#include "src/crs/crs.h"
#include "src/export/vertex_numbers.h"

namespace tessera::exports {

namespace fs = std::filesystem;

namespace {

constexpr std::uint64_t unused = ~std::uint64_t{0};

bool is_height(const Attribute& attribute) { return attribute.name == "z" && attribute.type == AttributeType::f64; }

// The rows of a tile, and where they have the heights.
class Rows {
 public:
  explicit Rows(const MeshSource& source)
      : attributes_(source.format.attributes && !source.manifest.schema.empty()),
        stride_(row_bytes(source.manifest.schema)) {
    if (source.manifest.dimension != 2 || !source.options.heights || source.format.heights_apart) return;
    std::size_t offset = 0;
    for (const auto& attribute : source.manifest.schema) {
      if (is_height(attribute)) height_at_ = offset;
      offset += size_of(attribute.type);
    }
  }

  bool heights() const { return height_at_.has_value(); }
  // Whether the format has any use for them.
  bool wanted() const { return attributes_ || heights(); }

  // Fetches the heights of a tile, which was read with its rows if they are wanted. Error usage when one is not finite.
  Status lift(const MeshSource& source, StoredTile& tile) const {
    if (!wanted()) return success();
    if (tile.schema != source.manifest.schema)
      return error(Errc::corrupt, source.out.string() + ": a tile has other attributes than the manifest");
    if (!height_at_) return success();
    for (std::size_t i = 0; i < tile.mesh.points.size(); ++i) {
      double z = 0;
      std::memcpy(&z, tile.rows.data() + i * stride_ + *height_at_, sizeof z);
      if (!std::isfinite(z))
        return error(Errc::usage, source.out.string() + ": the height of vertex " + to_string(tile.mesh.ids[i]) +
                                      " is not finite; " + option("z", "false") + " leaves the heights out");
      tile.mesh.points[i].z = z + 0.0;  // never -0, like every coordinate
    }
    return success();
  }
  VertexView vertex(const StoredTile& tile, std::size_t i) const {
    return {
        .at = tile.mesh.points[i], .id = tile.mesh.ids[i], .row = wanted() ? tile.rows.data() + i * stride_ : nullptr};
  }

 private:
  bool attributes_;
  std::size_t stride_;
  std::optional<std::size_t> height_at_;
};

// Asks now and then, not at each of millions, whether to go on; and tells how far it is.
class Watch {
 public:
  // `done`: the vertices and cells that earlier watches have seen.
  Watch(const MeshSource& source, MeshWriter& writer, std::uint64_t done = 0)
      : source_(source), writer_(writer), done_(done) {}
  Status step() {
    constexpr std::uint64_t every = 1 << 16;
    if (++done_ % every != 0) return success();
    return look();
  }
  Status look() {
    if (source_.stop.stop_requested()) return error(Errc::interrupted, "interrupted while exporting");
    const auto& manifest = source_.manifest;
    const std::uint64_t all = manifest.cells + (source_.format.corners ? 0 : manifest.vertices) + 1;
    if (source_.options.progress)
      source_.options.progress(std::min(1.0, static_cast<double>(done_ + 1) / static_cast<double>(all)));
    return writer_.check();
  }
  std::uint64_t done() const { return done_; }

 private:
  const MeshSource& source_;
  MeshWriter& writer_;
  std::uint64_t done_;
};

// More than announced would run into the next array of a file.
Error wrong_counts(const MeshSource& source, std::uint64_t vertices, std::uint64_t cells) {
  return error(Errc::corrupt, source.out.string() + ": the tiles hold " + std::to_string(vertices) + " vertices and " +
                                  std::to_string(cells) + " cells or more, the manifest counts " +
                                  std::to_string(source.manifest.vertices) + " and " +
                                  std::to_string(source.manifest.cells));
}

Result<StoredTile> load(const MeshSource& source, std::size_t index, bool with_rows) {
  const TileId id = source.manifest.tiles[index].tile;
  BOOST_OUTCOME_TRY(tile, read_tile(source.out, id, with_rows));
  if (tile.mesh.dimension != source.manifest.dimension)
    return error(Errc::corrupt, stored_tile_file(source.out, id).string() + ": has another dimension than the result");
  return std::move(tile);
}

// Gives the writer the main cells of a tile; the first has the number `first`.
Status give_cells(const MeshSource& source, const StoredTile& tile, std::size_t index, std::uint64_t first,
                  const std::vector<std::uint64_t>& numbers, MeshWriter& writer, Watch& watch) {
  const TileMesh& mesh = tile.mesh;
  const std::size_t corners = static_cast<std::size_t>(mesh.dimension) + 1;
  std::vector<std::uint64_t> cell_numbers;
  if (source.format.neighbors && source.manifest.neighbors) {
    cell_numbers.assign(mesh.cell_ghost.size(), unused);
    std::uint64_t next = first;
    for (std::size_t i = 0; i < cell_numbers.size(); ++i)
      if (mesh.cell_ghost[i] == 0) cell_numbers[i] = next++;
  }
  CellView cell{.tile = source.manifest.tiles[index].tile};
  for (std::size_t i = 0; i < mesh.cell_ghost.size(); ++i) {
    if (mesh.cell_ghost[i] != 0) continue;
    cell.own = 0;
    for (std::size_t k = 0; k < corners; ++k) {
      const auto v = static_cast<std::size_t>(mesh.cells[i * corners + k]);
      cell.ids[k] = mesh.ids[v];
      cell.own += mesh.point_ghost[v] == 0 ? 1 : 0;
      if (source.format.corners) {
        cell.at[k] = mesh.points[v];
      } else {
        cell.numbers[k] = numbers[v];
      }
      if (cell_numbers.empty()) continue;
      const std::int32_t beyond = mesh.neighbors[i * corners + k];
      const std::uint64_t number = beyond < 0 ? unused : cell_numbers[static_cast<std::size_t>(beyond)];
      cell.neighbors[k] = beyond == -1       ? CellView::outside
                          : number == unused ? CellView::elsewhere
                                             : static_cast<std::int64_t>(number);
    }
    writer.cell(cell);
    BOOST_OUTCOME_TRYV(watch.step());
  }
  return success();
}

template <class Ghosts>
std::uint64_t count_main(const Ghosts& ghosts) {
  return static_cast<std::uint64_t>(std::count(ghosts.begin(), ghosts.end(), 0));
}

}  // namespace

MeshHead head_of(const MeshSource& source) {
  const Manifest& manifest = source.manifest;
  MeshHead head;
  head.dimension = manifest.dimension;
  head.vertices = manifest.vertices;
  head.cells = manifest.cells;
  head.ids = manifest.points_read;
  head.neighbors = source.format.neighbors && manifest.neighbors;
  head.spatial_index = source.options.spatial_index;
  if (looks_like_crs(manifest.crs)) head.crs = manifest.crs;
  head.software_version = manifest.software_version;
  std::size_t offset = 0;
  for (const auto& attribute : manifest.schema) {
    const bool height = manifest.dimension == 2 && is_height(attribute);
    if (height && !source.format.heights_apart) {
      head.heights = source.options.heights;
    } else if (source.format.attributes && (!height || source.options.heights)) {
      head.columns.push_back({attribute.name, attribute.type, offset});
    }
    offset += size_of(attribute.type);
  }
  return head;
}

Status read_merged(const MeshSource& source, MeshWriter& writer) {
  const Manifest& manifest = source.manifest;
  const Rows rows(source);
  Watch watch(source, writer);
  std::uint64_t vertices = 0, cells = 0;
  VertexNumbers numbers;
  if (!source.format.corners) {
    BOOST_OUTCOME_TRY(prepared, VertexNumbers::prepare(source.out, manifest, source.stop));
    numbers = std::move(prepared);
    for (const auto& entry : manifest.tiles) {
      BOOST_OUTCOME_TRYV(watch.look());
      BOOST_OUTCOME_TRY(tile, read_tile_vertices(source.out, entry.tile, rows.wanted()));
      BOOST_OUTCOME_TRYV(rows.lift(source, tile));
      numbers.number_own(tile.mesh);
      vertices += count_main(tile.mesh.point_ghost);
      if (vertices > manifest.vertices) return wrong_counts(source, vertices, cells);
      for (std::size_t i = 0; i < tile.mesh.points.size(); ++i) {
        if (tile.mesh.point_ghost[i] != 0) continue;
        writer.vertex(rows.vertex(tile, i));
        BOOST_OUTCOME_TRYV(watch.step());
      }
    }
  }
  for (std::size_t index = 0; index < manifest.tiles.size(); ++index) {
    BOOST_OUTCOME_TRYV(watch.look());
    BOOST_OUTCOME_TRY(tile, load(source, index, source.format.corners && rows.heights()));
    std::vector<std::uint64_t> of;
    if (source.format.corners) {
      if (rows.heights()) {
        BOOST_OUTCOME_TRYV(rows.lift(source, tile));
      }
      vertices += count_main(tile.mesh.point_ghost);
    } else {
      BOOST_OUTCOME_TRY(found, numbers.of(tile.mesh, index, stored_tile_file(source.out, manifest.tiles[index].tile)));
      of = std::move(found);
    }
    const std::uint64_t first = cells;
    cells += count_main(tile.mesh.cell_ghost);
    if (cells > manifest.cells) return wrong_counts(source, vertices, cells);
    BOOST_OUTCOME_TRYV(give_cells(source, tile, index, first, of, writer, watch));
  }
  if (vertices != manifest.vertices || cells != manifest.cells) return wrong_counts(source, vertices, cells);
  return watch.look();
}

Result<TilePiece> write_piece(const MeshSource& source, std::size_t index, const fs::path& path, std::uint64_t& done) {
  const Rows rows(source);
  BOOST_OUTCOME_TRY(tile, load(source, index, rows.wanted()));
  BOOST_OUTCOME_TRYV(rows.lift(source, tile));
  const TileMesh& mesh = tile.mesh;
  const std::size_t corners = static_cast<std::size_t>(mesh.dimension) + 1;
  TilePiece piece{.own_vertices = count_main(mesh.point_ghost), .cells = count_main(mesh.cell_ghost)};
  std::vector<std::uint64_t> numbers(mesh.points.size(), unused);
  for (std::size_t i = 0; i < mesh.cell_ghost.size(); ++i) {
    if (mesh.cell_ghost[i] != 0) continue;
    for (std::size_t k = 0; k < corners; ++k) numbers[static_cast<std::size_t>(mesh.cells[i * corners + k])] = 0;
  }
  MeshHead head = head_of(source);
  head.cells = piece.cells;
  head.vertices = 0;
  for (auto& number : numbers)
    if (number != unused) number = head.vertices++;
  BOOST_OUTCOME_TRY(writer, source.format.open(path, head));
  Watch watch(source, *writer, done);
  if (!source.format.corners) {
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      if (numbers[i] == unused) continue;
      writer->vertex(rows.vertex(tile, i));
      BOOST_OUTCOME_TRYV(watch.step());
    }
  }
  BOOST_OUTCOME_TRYV(give_cells(source, tile, index, 0, numbers, *writer, watch));
  BOOST_OUTCOME_TRYV(watch.look());
  done = watch.done();
  BOOST_OUTCOME_TRY(bytes, writer->finish());
  piece.bytes = bytes;
  return piece;
}

}  // namespace tessera::exports
