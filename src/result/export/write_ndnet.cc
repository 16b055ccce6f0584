// NDnet, the format of networks of DisPerSE (T. Sousbie, The persistent cosmic web and its filamentary structure, MNRAS
// 414 (2011)). The layout is that of Save_NDnetwork() in src/C/NDnetwork.c of DisPerSE 0.9.25: blocks between two
// numbers of 32 bits, which say how many bytes a block has. DisPerSE does not look at these numbers, and the one of the
// coordinates counts numbers instead of bytes; so it does here.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <deque>
#include <limits>
#include <tuple>

#include "src/base/attribute_value.h"
#include "src/base/image.h"
#include "src/base/option.h"
#include "src/result/export/formats.h"
#include "src/result/export/ndnet.h"
#include "src/result/export/output.h"
#include "src/result/export/point_table.h"
#include "src/result/export/row_numbers.h"
#include "src/result/store/external_sort.h"

namespace tessera::exports {

namespace fs = std::filesystem;

namespace {

constexpr std::uint64_t cell_sort_bytes = std::uint64_t{256} << 20;
constexpr std::size_t name_bytes = 255;
constexpr std::uint8_t cut_by_period = 1 << 1;  // NDNETFLAG_PERIODIC_CUT

Error refuse_net(const MeshSource& source, const std::string& why) {
  return error(Errc::usage, source.out.string() + ": " + why);
}

// A cell by the numbers of its vertices, ascending.
struct NetCell {
  std::array<std::uint32_t, 4> vertices{};
  std::uint8_t turned = 0;  // whether the ascending order is an odd permutation of a positive one
  std::uint8_t flag = 0;
  friend bool operator<(const NetCell& a, const NetCell& b) {
    return std::tie(a.vertices, a.turned) < std::tie(b.vertices, b.turned);
  }
};

// The blocks of a file one after the other, in places that are known from the start.
class Blocks {
 public:
  explicit Blocks(const OutputFile& file) : file_(file) {}
  // Begins a block whose bytes are written later, side by side with those of other blocks. Writes the number before the
  // block; finish() writes the number after it. Both numbers are `told`.
  Stream& later(std::uint64_t bytes, std::uint64_t told) {
    Stream& stream = begin(told);
    ends_.push_back({at_ + 4 + bytes, static_cast<std::uint32_t>(told)});
    at_ += bytes + 8;
    return stream;
  }
  Stream& later(std::uint64_t bytes) { return later(bytes, bytes); }
  void now(const std::string& bytes) { later(bytes.size()).text(bytes); }
  Status status() const {
    for (const auto& stream : streams_) {
      BOOST_OUTCOME_TRYV(stream.status());
    }
    return success();
  }
  Status finish() {
    for (auto& stream : streams_) {
      BOOST_OUTCOME_TRYV(stream.flush());
    }
    for (const auto& [at, told] : ends_) {
      BOOST_OUTCOME_TRYV(write_at(file_.fd(), std::as_bytes(std::span(&told, 1)), at, file_.target()));
    }
    return success();
  }

 private:
  Stream& begin(std::uint64_t told) {
    Stream& stream = streams_.emplace_back(file_, at_);
    stream.value(static_cast<std::uint32_t>(told));
    return stream;
  }
  const OutputFile& file_;
  std::deque<Stream> streams_;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> ends_;  // where a block ends, and what its numbers say
  std::uint64_t at_ = 0;
};

template <class T>
void append(std::string& text, const T& value) {
  text.append(reinterpret_cast<const char*>(&value), sizeof value);
}

// The space of a network: a box, and the axes along which it is periodic.
struct NetBox {
  std::array<double, 3> origin{}, size{};
  std::int32_t periodic = 0;  // a bit for each axis; all bits when all axes are periodic, as DisPerSE has it
};

NetBox box_of(const MeshSource& source) {
  const Manifest& manifest = source.manifest;
  const Period& period = source.tiles->period();
  NetBox box;
  for (int axis = 0; axis < manifest.dimension; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    box.origin[a] = period.along(axis) ? 0 : manifest.bounds.lo[axis];
    box.size[a] = period.along(axis) ? period.length[a] : manifest.bounds.hi[axis] - manifest.bounds.lo[axis];
    if (period.along(axis)) box.periodic |= 1 << axis;
  }
  if (period.open_axes(manifest.dimension) == 0) box.periodic = ~0;
  return box;
}

std::string padded(std::string text, std::size_t bytes) {
  text.resize(bytes, '\0');
  return text;
}

void write_net_head(Blocks& blocks, const MeshSource& source, std::uint32_t vertices) {
  const std::int32_t dimension = source.manifest.dimension;
  const auto axes = static_cast<std::size_t>(dimension);
  blocks.now(padded("NDNETWORK", 16));
  std::string text;
  append(text, dimension);
  append(text, dimension);
  blocks.now(text);
  const NetBox box = box_of(source);
  // By this name mse knows that the field is a density of Delaunay cells.
  text = padded("delaunay_tesselation", 80);
  append(text, box.periodic);
  append(text, std::int32_t{1});  // of simplices
  for (std::size_t a = 0; a < axes; ++a) append(text, box.origin[a]);
  for (std::size_t a = 0; a < axes; ++a) append(text, box.size[a]);
  append(text, std::int32_t{4});  // bytes of an index
  append(text, std::int32_t{8});  // of a sum of counts
  text += padded("", 152);
  append(text, vertices);
  blocks.now(text);
}

// A coordinate as a float, within the box: the float nearest to a coordinate below the period may be the period.
float net_coordinate(double x, double period) {
  const auto rounded = static_cast<float>(x);
  return period > 0 && rounded >= period ? std::nextafter(rounded, 0.0F) : rounded;
}

// The numbers of a network's blocks that need no reading.
std::string numbers_of(std::initializer_list<std::uint32_t> numbers) {
  std::string text;
  for (const std::uint32_t number : numbers) append(text, number);
  return text;
}

struct NetStreams {
  Stream* coordinates = nullptr;
  Stream* cells = nullptr;
  Stream* flags = nullptr;
  std::vector<Stream*> fields = {};  // the field, its logarithm, the other columns
};

NetStreams lay_out(Blocks& blocks, const MeshSource& source, const std::vector<std::string>& fields) {
  const auto vertices = static_cast<std::uint32_t>(source.manifest.vertices);
  const auto cells = static_cast<std::uint32_t>(source.manifest.cells);
  const auto axes = static_cast<std::uint64_t>(source.manifest.dimension);
  const auto by_face = [&](std::uint32_t last) {
    return axes == 2 ? numbers_of({0, 0, last}) : numbers_of({0, 0, 0, last});
  };
  NetStreams streams;
  write_net_head(blocks, source, vertices);
  streams.coordinates = &blocks.later(axes * vertices * sizeof(float), axes * vertices);
  blocks.now(by_face(cells));  // how many faces of each dimension
  blocks.now(by_face(1));      // which of them are listed by their vertices
  streams.cells = &blocks.later((axes + 1) * cells * sizeof(std::uint32_t));
  blocks.now(by_face(0));                               // no lists of the faces around a vertex
  blocks.now(padded("", (axes + 1) * (axes + 1) * 4));  // nor of faces around faces
  blocks.now(numbers_of({1}));                          // vertices have flags
  blocks.later(vertices);                               // all 0: nothing is written there
  blocks.now(by_face(1));                               // and so have cells
  streams.flags = &blocks.later(cells);
  blocks.now(numbers_of({static_cast<std::uint32_t>(fields.size())}));
  for (const auto& field : fields) {
    std::string text = numbers_of({0});  // of vertices
    blocks.now(text + padded(field.substr(0, name_bytes - 1), name_bytes));
    streams.fields.push_back(&blocks.later(std::uint64_t{vertices} * sizeof(double)));
  }
  blocks.now(numbers_of({0}));  // no data of other kinds
  return streams;
}

// Writes coordinates and fields of the vertices, and numbers them.
Status write_net_vertices(const MeshSource& source, const PointTable& table, const fs::path& scratch,
                          NetStreams& streams, const Blocks& blocks, RowNumbers& numbers) {
  const auto axes = static_cast<std::size_t>(source.manifest.dimension);
  const std::size_t first = table.columns().size() - (streams.fields.size() - 1);  // without the logarithm
  const auto write = [&](const std::byte* row) {
    for (std::size_t a = 0; a < axes; ++a) {
      double x = 0;
      std::memcpy(&x, row + table.columns()[1 + a].offset, sizeof x);
      streams.coordinates->value(net_coordinate(x, source.tiles->period().length[a]));
    }
    for (std::size_t i = 0; i + 1 < streams.fields.size(); ++i) {
      const TableColumn& column = table.columns()[first + i];
      const double value = as_double(column.type, row + column.offset);
      streams.fields[i == 0 ? 0 : i + 1]->value(value);
      if (i == 0) streams.fields[1]->value(std::log(value));
    }
  };
  return table.for_each(scratch, [&](std::span<const std::byte> rows) -> Status {
    for (std::size_t at = 0; at < rows.size(); at += table.row_bytes()) {
      const std::byte* row = rows.data() + at;
      PointId id;
      std::memcpy(&id, row, sizeof id);
      if (table.vertex_of(row) != id) continue;  // a duplicate is no vertex of a network
      numbers.add(id);
      write(row);
    }
    return blocks.status();
  });
}

Status sort_cells(const MeshSource& source, const TileMesh& mesh, const RowNumbers& numbers,
                  ExternalSort<NetCell>& sorted) {
  const std::size_t corners = static_cast<std::size_t>(mesh.dimension) + 1;
  for (std::size_t i = 0; i < mesh.cell_ghost.size(); ++i) {
    if (mesh.cell_ghost[i] != 0) continue;
    NetCell cell;
    for (std::size_t k = 0; k < corners; ++k) {
      const auto v = static_cast<std::size_t>(mesh.cells[i * corners + k]);
      if (!numbers.has(mesh.ids[v]))
        return error(Errc::corrupt, source.out.string() + ": a cell has the vertex " + to_string(mesh.ids[v]) +
                                        ", which no tile owns");
      cell.vertices[k] = numbers.of(mesh.ids[v]);
      if (!mesh.offsets.empty() && mesh.offsets[v] != 0) cell.flag = cut_by_period;
      for (std::size_t j = k; j > 0 && cell.vertices[j] < cell.vertices[j - 1]; --j) {
        std::swap(cell.vertices[j], cell.vertices[j - 1]);
        cell.turned ^= 1;
      }
    }
    for (std::size_t k = 1; k < corners; ++k)
      if (cell.vertices[k] == cell.vertices[k - 1])
        return refuse_net(source,
                          "has a cell with two images of one point, and the cells of an NDnet name points alone; "
                          "more points make cells shorter than a period");
    BOOST_OUTCOME_TRYV(sorted.push(cell));
  }
  return success();
}

// Writes the cells in the order of their vertices, which does not depend on tiles.
Status write_net_cells(const MeshSource& source, const fs::path& scratch, const RowNumbers& numbers,
                       NetStreams& streams, const Blocks& blocks) {
  const TileSource tiles = source.tiles->stopped_by(source.stop);
  ExternalSort<NetCell> sorted(scratch, cell_sort_bytes, source.stop);
  for (std::size_t index = 0; index < tiles.tiles(); ++index) {
    if (source.stop.stop_requested()) return error(Errc::interrupted, "interrupted while exporting");
    if (source.options.progress)
      source.options.progress(static_cast<double>(index) / static_cast<double>(tiles.tiles()));
    BOOST_OUTCOME_TRY(tile, tiles.read(index, {.cells = true}));
    BOOST_OUTCOME_TRYV(sort_cells(source, tile.mesh, numbers, sorted));
  }
  const std::size_t corners = static_cast<std::size_t>(source.manifest.dimension) + 1;
  NetCell last;
  return sorted.for_each([&](const NetCell& cell) -> Status {
    if (cell.vertices == last.vertices)
      return refuse_net(source,
                        "has two cells with images of the same points, and the cells of an NDnet name points alone; "
                        "more points make cells shorter than a period");
    last = cell;
    auto vertices = cell.vertices;
    if (cell.turned != 0) std::swap(vertices[corners - 2], vertices[corners - 1]);
    for (std::size_t k = 0; k < corners; ++k) streams.cells->value(vertices[k]);
    streams.flags->value(cell.flag);
    return blocks.status();
  });
}

}  // namespace

Result<Exported> write_ndnet_file(const MeshSource& source, const fs::path& path, std::uint64_t most) {
  const Manifest& manifest = source.manifest;
  if (std::max(manifest.vertices, manifest.cells) > most)
    return refuse_net(source, "has " + std::to_string(manifest.vertices) + " vertices and " +
                                  std::to_string(manifest.cells) + " cells, and the numbers in an NDnet end at " +
                                  std::to_string(most));
  std::vector<std::string> columns = source.options.names;
  if (columns.empty()) {
    if (!column_of(manifest.schema, "density"))
      return refuse_net(source, "has no column 'density', the field of an NDnet; measuring it with " +
                                    option("density", "true") + " computes it, or give " + option("names"));
    columns = {"density"};
  }
  BOOST_OUTCOME_TRY(table, PointTable::open(source, columns));
  std::vector<std::string> fields{"field_value", "log_field_value"};
  fields.insert(fields.end(), columns.begin() + 1, columns.end());
  BOOST_OUTCOME_TRY(file, OutputFile::create(path));
  Blocks blocks(file);
  NetStreams streams = lay_out(blocks, source, fields);
  RowNumbers numbers(manifest.points_read, manifest.vertices);
  BOOST_OUTCOME_TRYV(write_net_vertices(source, table, folder_of(path), streams, blocks, numbers));
  BOOST_OUTCOME_TRYV(write_net_cells(source, folder_of(path), numbers, streams, blocks));
  BOOST_OUTCOME_TRYV(blocks.finish());
  BOOST_OUTCOME_TRY(bytes, file.finish());
  Exported exported;
  exported.vertices = manifest.vertices;
  exported.cells = manifest.cells;
  exported.files = 1;
  exported.bytes = bytes;
  return exported;
}

Result<Exported> write_ndnet(const MeshSource& source, const fs::path& path) {
  return write_ndnet_file(source, path, ndnet_most);
}

}  // namespace tessera::exports
