// A folder of NumPy arrays, which numpy.load(mmap_mode="r") opens without reading them:
//  points.npy     f8 n x dimension      ids.npy        u8 n        <attribute>.npy  n; in 2D also z.npy
//  cells.npy      i8 m x (d+1)          tile.npy       u4 m, the tile in which the cell is main
//  neighbors.npy  i8 m x (d+1), across the facet opposite each vertex; -1 the outside; if the result has neighbours
//  cell_<column>.npy  m; columns of cells
//  final.npy      u1 m, whether each cell is surely one of the whole triangulation; only for a region
#include <algorithm>
#include <deque>
#include <set>
#include <tuple>

#include "src/base/image.h"
#include "src/result/export/boundary.h"
#include "src/result/export/formats.h"
#include "src/result/export/output.h"
#include "src/result/store/external_sort.h"

namespace tessera::exports {

namespace fs = std::filesystem;

namespace {

const char* npy_type(AttributeType type) {
  constexpr const char* names[] = {"|u1", "|i1", "<u2", "<i2", "<u4", "<i4", "<u8", "<i8", "<f4", "<f8"};
  return names[static_cast<int>(type)];
}

struct Array {
  OutputFile file;
  Stream stream;
};

// A facet between two tiles, by the ids of its vertices. In a periodic result these are images, shifted so that the
// facet has the same ids wherever it lies.
struct OpenFacet {
  std::array<PointId, 3> ids{};
  std::uint64_t cell = 0;
  std::uint64_t place = 0;  // index of the neighbour's entry in neighbors.npy
  friend bool operator<(const OpenFacet& a, const OpenFacet& b) {
    return std::tie(a.ids, a.place) < std::tie(b.ids, b.place);
  }
};

class NpyWriter : public MeshWriter {
 public:
  static OpenedWriter open(const fs::path& folder, const MeshHead& head) {
    auto writer = std::unique_ptr<NpyWriter>(new NpyWriter(folder, head));
    const auto d = static_cast<std::uint64_t>(head.dimension);
    BOOST_OUTCOME_TRYV(writer->add("points", AttributeType::f64, head.vertices, d));
    BOOST_OUTCOME_TRYV(writer->add("ids", AttributeType::u64, head.vertices, 0));
    BOOST_OUTCOME_TRYV(writer->add("cells", AttributeType::i64, head.cells, d + 1));
    BOOST_OUTCOME_TRYV(writer->add("tile", AttributeType::u32, head.cells, 0));
    if (head.neighbors) {
      BOOST_OUTCOME_TRYV(writer->add("neighbors", AttributeType::i64, head.cells, d + 1));
    }
    std::set<std::string> taken{"points", "ids", "cells", "tile", "neighbors", "final"};
    for (const auto& column : head.columns) {
      std::string name = column.name;
      while (!taken.insert(name).second) name += '_';
      BOOST_OUTCOME_TRYV(writer->add(name, column.type, head.vertices,
                                     column.components > 1 ? static_cast<std::uint64_t>(column.components) : 0));
    }
    writer->first_of_cells_ = writer->arrays_.size();
    for (const auto& column : head.cell_columns) {
      std::string name = "cell_" + column.name;
      while (!taken.insert(name).second) name += '_';
      BOOST_OUTCOME_TRYV(writer->add(name, column.type, head.cells, 0));
    }
    if (head.final) {
      BOOST_OUTCOME_TRYV(writer->add("final", AttributeType::u8, head.cells, 0));
    }
    return std::unique_ptr<MeshWriter>(std::move(writer));
  }

  void vertex(const VertexView& vertex) override {
    for (int axis = 0; axis < head_.dimension; ++axis) arrays_[points].stream.value(vertex.at[axis]);
    arrays_[ids].stream.value(vertex.id);
    for (std::size_t c = 0; c < head_.columns.size(); ++c)
      arrays_[first_column() + c].stream.bytes({vertex.row + head_.columns[c].offset, head_.columns[c].bytes()});
  }

  void cell(const CellView& cell) override {
    const std::size_t corners = head_.corners();
    for (std::size_t k = 0; k < corners; ++k) arrays_[cells].stream.value(static_cast<std::int64_t>(cell.numbers[k]));
    arrays_[tile].stream.value(cell.tile);
    for (std::size_t c = 0; c < head_.cell_columns.size(); ++c)
      arrays_[first_of_cells_ + c].stream.bytes({cell.values[c], size_of(head_.cell_columns[c].type)});
    if (head_.final) arrays_.back().stream.value(static_cast<std::uint8_t>(cell.final));
    if (head_.neighbors) {
      for (std::size_t k = 0; k < corners; ++k) {
        // Until its other side is found, a facet between tiles counts as one on the outside.
        const bool open = cell.neighbors[k] == CellView::elsewhere;
        arrays_[neighbors].stream.value(open ? CellView::outside : cell.neighbors[k]);
        if (!open || !status_) continue;
        OpenFacet facet{.cell = cells_, .place = cells_ * corners + k};
        for (std::size_t i = 0, at = 0; i < corners; ++i)
          if (i != k) facet.ids[at++] = cell.images[i];
        sort_up_to_shifts(std::span(facet.ids).first(static_cast<std::size_t>(head_.dimension)));
        status_ = open_facets_.push(facet);
      }
    }
    ++cells_;
  }

  Status check() override {
    for (const auto& array : arrays_) {
      BOOST_OUTCOME_TRYV(array.stream.status());
    }
    return status_;
  }

  Result<std::uint64_t> finish() override {
    BOOST_OUTCOME_TRYV(check());
    for (auto& array : arrays_) {
      BOOST_OUTCOME_TRYV(array.stream.flush());
    }
    if (head_.neighbors) {
      BOOST_OUTCOME_TRYV(match_facets());
    }
    std::uint64_t bytes = 0;
    for (auto& array : arrays_) {
      BOOST_OUTCOME_TRY(size, array.file.finish());
      bytes += size;
    }
    return bytes;
  }

 private:
  enum : std::size_t { points, ids, cells, tile, neighbors };
  static constexpr std::size_t header_bytes = 128;

  NpyWriter(const fs::path& folder, const MeshHead& head)
      : folder_(folder), head_(head), open_facets_(folder, facet_sort_bytes) {}

  std::size_t first_column() const { return head_.neighbors ? neighbors + 1 : neighbors; }

  // With `columns` 0 the array has one dimension.
  Status add(const std::string& name, AttributeType type, std::uint64_t rows, std::uint64_t columns) {
    BOOST_OUTCOME_TRY(file, OutputFile::create(folder_ / (name + ".npy")));
    Stream stream(file, 0);
    std::string text = std::string("{'descr': '") + npy_type(type) + "', 'fortran_order': False, 'shape': (" +
                       std::to_string(rows) + ", " + (columns > 0 ? std::to_string(columns) : "") + "), }";
    text.resize(header_bytes - 11, ' ');
    stream.bytes(std::as_bytes(std::span("\x93NUMPY\x01\x00\x76\x00", 10)));
    stream.text(text + "\n");
    arrays_.push_back({std::move(file), std::move(stream)});
    return success();
  }

  // Sorting puts the two main cells of a facet, which are in different tiles, side by side. A facet with one cell is on
  // the outside.
  Status match_facets() {
    const OutputFile& file = arrays_[neighbors].file;
    const auto set = [&](const OpenFacet& facet, std::uint64_t neighbor) {
      return write_at(file.fd(), std::as_bytes(std::span(&neighbor, 1)), header_bytes + facet.place * 8, file.target());
    };
    const auto same = [](const OpenFacet& a, const OpenFacet& b) { return a.ids == b.ids; };
    return for_each_group(open_facets_, 3, same, [&](std::span<const OpenFacet> group) -> Status {
      if (group.size() == 1) return success();
      if (group.size() > 2) return error(Errc::corrupt, "a facet of the result belongs to more than two cells");
      BOOST_OUTCOME_TRYV(set(group[0], group[1].cell));
      return set(group[1], group[0].cell);
    });
  }

  fs::path folder_;
  MeshHead head_;
  std::deque<Array> arrays_;
  ExternalSort<OpenFacet> open_facets_;
  std::size_t first_of_cells_ = 0;  // index in arrays_ of the first column of cells
  std::uint64_t cells_ = 0;
  Status status_ = success();
};

}  // namespace

OpenedWriter open_npy(const fs::path& path, const MeshHead& head) { return NpyWriter::open(path, head); }

}  // namespace tessera::exports
