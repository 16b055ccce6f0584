#include "src/result/export/mesh_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <numeric>
#include <optional>
#include <vector>

#include "src/base/crs/crs.h"
#include "src/base/image.h"
#include "src/base/option.h"

namespace tessera::exports {

namespace fs = std::filesystem;

namespace {

constexpr std::uint64_t unused = ~std::uint64_t{0};

bool is_height(const Attribute& attribute) { return attribute.name == "z" && attribute.type == AttributeType::f64; }

// Whether vertices have their offsets as an attribute. Formats without a list of vertices have them in the cells.
bool has_offsets(const MeshSource& source) {
  return source.format.attributes && !source.format.corners && source.tiles != nullptr && source.tiles->period().any();
}
constexpr std::size_t offset_bytes = 3;  // an i8 for each axis, behind the attributes

// Finds the attributes of vertices, and the height among them. In a periodic result the offsets of vertices are
// attributes, too.
class Rows {
 public:
  explicit Rows(const MeshSource& source)
      : offsets_(has_offsets(source)),
        attributes_(source.format.attributes && (offsets_ || !source.manifest.schema.empty())),
        stored_(row_bytes(source.manifest.schema)),
        stride_(stored_ + (offsets_ ? offset_bytes : 0)),
        corner_(corner_of(source).value_or(Point{})) {
    if (source.manifest.dimension != 2 || !source.options.heights || source.format.heights_apart) return;
    std::size_t offset = 0;
    for (const auto& attribute : source.manifest.schema) {
      if (is_height(attribute)) height_at_ = offset;
      offset += size_of(attribute.type);
    }
  }

  bool heights() const { return height_at_.has_value(); }
  // True if the format uses rows.
  bool wanted() const { return attributes_ || heights(); }

  // Adds the offsets to a tile's rows, and sets the z of its points to their heights. The tile was read with rows if
  // they are wanted. Error usage when a height is not finite.
  Status lift(const MeshSource& source, StoredTile& tile) const {
    if (offsets_) widen(tile);
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
  const std::byte* row(const StoredTile& tile, std::size_t i) const {
    return wanted() ? tile.rows.data() + i * stride_ : nullptr;
  }
  VertexView vertex(const StoredTile& tile, std::size_t i) const {
    const Point& at = tile.mesh.points[i];
    return {.at = {at.x - corner_.x, at.y - corner_.y, at.z - corner_.z}, .id = tile.mesh.ids[i], .row = row(tile, i)};
  }

 private:
  void widen(StoredTile& tile) const {
    std::vector<std::byte> rows(tile.mesh.points.size() * stride_);
    for (std::size_t i = 0; i < tile.mesh.points.size(); ++i) {
      std::byte* row = rows.data() + i * stride_;
      std::copy_n(tile.rows.data() + i * stored_, stored_, row);
      const PeriodOffset offset = image::offset(tile.mesh.offsets.empty() ? 0 : tile.mesh.offsets[i]);
      for (std::size_t axis = 0; axis < offset_bytes; ++axis)
        row[stored_ + axis] = static_cast<std::byte>(static_cast<std::int8_t>(offset.by[axis]));
    }
    tile.rows.swap(rows);
  }

  bool offsets_, attributes_;
  std::size_t stored_, stride_;
  Point corner_;
  std::optional<std::size_t> height_at_;
};

// The columns that the file has of each vertex, besides its position.
std::vector<Column> columns_of(const MeshSource& source) {
  std::vector<Column> columns;
  if (!source.format.attributes) return columns;
  std::size_t offset = 0;
  for (const auto& attribute : source.manifest.schema) {
    const bool height = source.manifest.dimension == 2 && is_height(attribute);
    if (!height || (source.format.heights_apart && source.options.heights))
      columns.push_back({attribute.name, attribute.type, offset});
    offset += size_of(attribute.type);
  }
  if (!has_offsets(source)) return columns;
  if (source.format.vectors) {
    columns.push_back({"period_offset", AttributeType::i8, offset, static_cast<int>(offset_bytes)});
    return columns;
  }
  for (const char* axis : {"x", "y", "z"})
    columns.push_back({std::string("period_offset_") + axis, AttributeType::i8, offset++});
  return columns;
}

// Checks now and then, not for each of millions, whether to go on, and reports progress.
class Watch {
 public:
  // `all` vertices and cells are to be written; `done` of them were seen by earlier watches.
  Watch(const MeshSource& source, const Selection& selection, MeshWriter& writer, std::uint64_t done = 0)
      : source_(source),
        writer_(writer),
        all_(selection.cells + (lists_vertices(source) ? selection.vertices : 0) + 1),
        done_(done) {}
  Status step() {
    constexpr std::uint64_t every = 1 << 16;
    if (++done_ % every != 0) return success();
    return look();
  }
  Status look() {
    if (source_.stop.stop_requested()) return error(Errc::interrupted, "interrupted while exporting");
    if (source_.options.progress)
      source_.options.progress(std::min(1.0, static_cast<double>(done_ + 1) / static_cast<double>(all_)));
    return writer_.check();
  }
  std::uint64_t done() const { return done_; }

 private:
  const MeshSource& source_;
  MeshWriter& writer_;
  std::uint64_t all_, done_;
};

// How a writer gets the corners of cells: by the numbers of their vertices, or by their coordinates and rows.
struct Corners {
  const std::vector<std::uint64_t>& numbers;
  const Rows& rows;
};

// Values of cells in addition to the result's columns: ExportOptions::longest_edges, and in a periodic result the
// offsets of the corners, for formats without a list of vertices. Formats with edge_lengths write
// the longest edge by themselves.
class Facts {
 public:
  explicit Facts(const MeshSource& source)
      : edge_(source.options.longest_edges && source.format.cell_columns && !source.format.edge_lengths),
        tile_(source.options.longest_edges && source.format.cell_columns && source.format.tile_as_column),
        offsets_(source.format.cell_columns && source.format.corners && source.tiles != nullptr &&
                 source.tiles->period().any()) {}
  void declare(std::vector<Attribute>& columns) const {
    if (offsets_)  // such formats are for 2D results
      for (const char* name :
           {"v0_offset_x", "v0_offset_y", "v1_offset_x", "v1_offset_y", "v2_offset_x", "v2_offset_y"})
        columns.push_back({name, AttributeType::i8});
    if (edge_) columns.push_back({"longest_edge", AttributeType::f64});
    if (tile_) columns.push_back({"tile", AttributeType::u32});
  }
  void add_to(CellView& cell) {
    if (offsets_)
      for (const std::int8_t& by : offset_by_) cell.values.push_back(reinterpret_cast<const std::byte*>(&by));
    if (edge_) cell.values.push_back(reinterpret_cast<const std::byte*>(&length_));
    if (tile_) cell.values.push_back(reinterpret_cast<const std::byte*>(&cell.tile));
  }
  // Looks at a cell whose vertices have their heights.
  void look_at(const TileMesh& mesh, std::size_t cell) {
    if (edge_) length_ = longest_edge_in_space(mesh, cell);
    for (std::size_t k = 0; offsets_ && k < 3; ++k) {
      const auto v = static_cast<std::size_t>(mesh.cells[cell * 3 + k]);
      const PeriodOffset offset = image::offset(mesh.offsets.empty() ? 0 : mesh.offsets[v]);
      offset_by_[2 * k] = static_cast<std::int8_t>(offset.by[0]);
      offset_by_[2 * k + 1] = static_cast<std::int8_t>(offset.by[1]);
    }
  }

 private:
  bool edge_, tile_, offsets_;
  double length_ = 0;
  std::array<std::int8_t, 6> offset_by_{};  // of the three corners, along x and y
};

// Passes the exported cells of a tile to the writer. The first has the number `first`. `tile_of` returns the main tile
// of each cell.
template <class TileOf>
Status give_cells(const MeshSource& source, const StoredTile& tile, const TileOf& tile_of, std::uint64_t first,
                  const Corners& of, MeshWriter& writer, Watch& watch) {
  const TileMesh& mesh = tile.mesh;
  const std::size_t corners = static_cast<std::size_t>(mesh.dimension) + 1;
  std::vector<std::uint64_t> cell_numbers;
  if (source.format.neighbors && source.manifest.neighbors) {
    cell_numbers.assign(mesh.cell_ghost.size(), unused);
    std::uint64_t next = first;
    for (std::size_t i = 0; i < cell_numbers.size(); ++i)
      if (source.filter.keeps(mesh, i)) cell_numbers[i] = next++;
  }
  const auto is_own = [&](std::size_t v, TileId by) { return mesh.owners[v] == by; };
  CellView cell;
  cell.neighbors.fill(CellView::elsewhere);
  cell.values.resize(source.format.cell_columns ? tile.cell_columns.size() : 0);
  const std::size_t stored = cell.values.size();
  Facts facts(source);
  facts.add_to(cell);
  for (std::size_t i = 0; i < mesh.cell_ghost.size(); ++i) {
    if (!source.filter.keeps(mesh, i)) continue;
    if (source.format.edge_lengths)
      cell.longest_edge = source.options.longest_edges ? longest_edge_in_space(mesh, i) : longest_edge(mesh, i);
    cell.tile = tile_of(i);
    cell.own = 0;
    cell.final = mesh.cell_final.empty() || mesh.cell_final[i] != 0;
    facts.look_at(mesh, i);
    for (std::size_t c = 0; c < stored; ++c)
      cell.values[c] = tile.cell_columns[c].data() + i * size_of(tile.cell_schema[c].type);
    for (std::size_t k = 0; k < corners; ++k) {
      const auto v = static_cast<std::size_t>(mesh.cells[i * corners + k]);
      cell.ids[k] = mesh.ids[v];
      cell.images[k] = mesh.offsets.empty() ? mesh.ids[v] : image_of(mesh.ids[v], image::offset(mesh.offsets[v]));
      cell.own += is_own(v, cell.tile) ? 1 : 0;
      if (source.format.corners || source.format.edge_lengths) cell.at[k] = mesh.points[v];
      if (source.format.corners) {
        cell.rows[k] = of.rows.row(tile, v);
      } else {
        cell.numbers[k] = of.numbers[v];
      }
      if (cell_numbers.empty()) continue;
      const std::int32_t beyond = mesh.neighbors[i * corners + k];
      const auto b = static_cast<std::size_t>(std::max(beyond, 0));
      const bool left_out = beyond >= 0 && mesh.cell_ghost[b] == 0 && cell_numbers[b] == unused;
      cell.neighbors[k] = beyond == -1 || left_out                  ? CellView::outside
                          : beyond < 0 || cell_numbers[b] == unused ? CellView::elsewhere
                                                                    : static_cast<std::int64_t>(cell_numbers[b]);
    }
    writer.cell(cell);
    BOOST_OUTCOME_TRYV(watch.step());
  }
  return success();
}

// For cells that all belong to one tile.
auto tile_of(const MeshSource& source, std::size_t index) {
  return [tile = source.manifest.tiles[index].tile](std::size_t) { return tile; };
}

// Passes the own vertices of all tiles to the writer, and numbers them.
Status give_vertices(const MeshSource& source, Selection& selection, const Rows& rows, MeshWriter& writer,
                     Watch& watch) {
  const auto read = [&](std::size_t index) {
    return source.tiles->read(index, {.cells = source.filter.active(), .rows = rows.wanted()});
  };
  for (std::size_t index = 0; index < selection.ranges.size(); ++index) {
    BOOST_OUTCOME_TRYV(watch.look());
    BOOST_OUTCOME_TRY(tile, read(index));
    BOOST_OUTCOME_TRYV(rows.lift(source, tile));
    const auto exported = selection.numbers.exported_with(tile.mesh, index);
    selection.numbers.number_own(tile.mesh, exported);
    for (std::size_t i = 0; i < exported.size(); ++i) {
      if (exported[i] == 0) continue;
      writer.vertex(rows.vertex(tile, i));
      BOOST_OUTCOME_TRYV(watch.step());
    }
  }
  return success();
}

}  // namespace

std::optional<Point> corner_of(const MeshSource& source) {
  if (!source.options.local) return std::nullopt;
  Point corner = source.manifest.bounds.lo;
  for (int axis = 0; axis < 3; ++axis) corner[axis] = axis < source.manifest.dimension ? std::floor(corner[axis]) : 0;
  return corner;
}

std::string MeshHead::corner_comment() const {
  if (!corner) return {};
  std::array<char, 120> text{};
  std::snprintf(text.data(), text.size(), "coordinates count from %.0f %.0f %.0f", corner->x, corner->y, corner->z);
  return text.data();
}

MeshHead head_of(const MeshSource& source, const Selection& selection) {
  const Manifest& manifest = source.manifest;
  MeshHead head;
  head.dimension = manifest.dimension;
  head.vertices = selection.vertices;
  head.cells = selection.cells;
  head.ranges = selection.ranges;
  head.ids = manifest.points_read;
  head.neighbors = source.format.neighbors && manifest.neighbors;
  head.final = source.manifest.region && !source.manifest.region->complete;
  head.corner = corner_of(source);
  head.spatial_index = source.options.spatial_index;
  head.comment = source.options.comment;
  head.crs = crs_or_none(manifest.crs);
  head.software_version = manifest.software_version;
  if (source.options.comment.empty()) head.stamp = stamp_of(manifest);
  head.columns = columns_of(source);
  // Cells in memory, which a query has found, have no columns.
  if (source.format.cell_columns && source.tiles != nullptr) head.cell_columns = cell_schema_of(manifest);
  Facts(source).declare(head.cell_columns);
  head.heights = Rows(source).heights();
  return head;
}

bool lists_vertices(const MeshSource& source) {
  return !source.format.corners || (source.format.vertex_layer && !columns_of(source).empty());
}

Status read_merged(const MeshSource& source, Selection& selection, MeshWriter& writer) {
  const Rows rows(source);
  Watch watch(source, selection, writer);
  if (lists_vertices(source)) {
    BOOST_OUTCOME_TRYV(give_vertices(source, selection, rows, writer, watch));
  }
  std::uint64_t cells = 0;
  const bool places_wanted = source.format.corners || source.options.longest_edges;
  for (std::size_t index = 0; index < selection.ranges.size(); ++index) {
    BOOST_OUTCOME_TRYV(watch.look());
    BOOST_OUTCOME_TRY(tile, source.tiles->read(index, {.rows = places_wanted && rows.wanted(),
                                                       .cell_columns = source.format.cell_columns}));
    std::vector<std::uint64_t> numbers;
    if (places_wanted) {
      BOOST_OUTCOME_TRYV(rows.lift(source, tile));
    }
    if (!source.format.corners) {
      const fs::path file = source.tiles->file(index);
      BOOST_OUTCOME_TRY(found, selection.numbers.of(tile.mesh, index, file));
      numbers = std::move(found);
    }
    BOOST_OUTCOME_TRYV(give_cells(source, tile, tile_of(source, index), cells, {numbers, rows}, writer, watch));
    cells += selection.ranges[index].cells;
  }
  return watch.look();
}

Status write_cells(const MeshSource& source, const Selection& selection, StoredTile& cells,
                   std::span<const TileId> tiles, MeshWriter& writer) {
  const Rows rows(source);
  BOOST_OUTCOME_TRYV(rows.lift(source, cells));
  Watch watch(source, selection, writer);
  std::vector<std::uint64_t> numbers(cells.mesh.points.size());
  std::iota(numbers.begin(), numbers.end(), std::uint64_t{0});
  if (lists_vertices(source)) {
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      writer.vertex(rows.vertex(cells, i));
      BOOST_OUTCOME_TRYV(watch.step());
    }
  }
  BOOST_OUTCOME_TRYV(give_cells(
      source, cells, [&](std::size_t i) { return tiles[i]; }, 0, {numbers, rows}, writer, watch));
  return watch.look();
}

Result<std::uint64_t> write_piece(const MeshSource& source, const Selection& selection, std::size_t index,
                                  const fs::path& path, std::uint64_t& done) {
  const Rows rows(source);
  BOOST_OUTCOME_TRY(tile,
                    source.tiles->read(index, {.rows = rows.wanted(), .cell_columns = source.format.cell_columns}));
  BOOST_OUTCOME_TRYV(rows.lift(source, tile));
  const TileMesh& mesh = tile.mesh;
  const std::size_t corners = static_cast<std::size_t>(mesh.dimension) + 1;
  std::vector<std::uint64_t> numbers(mesh.points.size(), unused);
  for (std::size_t i = 0; i < mesh.cell_ghost.size(); ++i) {
    if (!source.filter.keeps(mesh, i)) continue;
    for (std::size_t k = 0; k < corners; ++k) numbers[static_cast<std::size_t>(mesh.cells[i * corners + k])] = 0;
  }
  MeshHead head = head_of(source, selection);
  head.vertices = 0;
  for (auto& number : numbers)
    if (number != unused) number = head.vertices++;
  head.cells = selection.ranges[index].cells;
  head.ranges = {{selection.ranges[index].tile, head.vertices, head.cells}};
  BOOST_OUTCOME_TRY(writer, source.format.open(path, head));
  Watch watch(source, selection, *writer, done);
  if (lists_vertices(source)) {
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      if (numbers[i] == unused) continue;
      writer->vertex(rows.vertex(tile, i));
      BOOST_OUTCOME_TRYV(watch.step());
    }
  }
  BOOST_OUTCOME_TRYV(give_cells(source, tile, tile_of(source, index), 0, {numbers, rows}, *writer, watch));
  BOOST_OUTCOME_TRYV(watch.look());
  done = watch.done();
  return writer->finish();
}

}  // namespace tessera::exports
