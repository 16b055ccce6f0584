// The interface between results and file formats: a writer gets the head, then every vertex, then every cell.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/store/stamp.h"

namespace tessera::exports {

// An attribute of the vertices that the file is to hold.
struct Column {
  std::string name;
  AttributeType type = AttributeType::f64;
  std::size_t offset = 0;  // in VertexView::row
  int components = 1;      // 3 only for formats with vectors: values that follow each other
  std::size_t bytes() const { return size_of(type) * static_cast<std::size_t>(components); }
};

// The number of vertices and cells of a tile in a file.
struct TileRange {
  TileId tile;
  std::uint64_t vertices = 0, cells = 0;
};

struct MeshHead {
  int dimension = 3;
  bool heights = false;  // 2D: points have a z that is no part of the triangulation
  std::uint64_t vertices = 0, cells = 0;
  std::vector<TileRange> ranges;  // the tiles, in the order in which vertices and cells come
  std::uint64_t ids = 0;          // every id is less than this
  bool neighbors = false;
  bool final = false;  // for a region: CellView::final has a meaning
  bool spatial_index = true;
  std::optional<Point> corner = {};  // the origin of the coordinates, for a comment
  std::vector<Column> columns;
  std::vector<Attribute> cell_columns = {};  // for formats that hold values of cells
  std::string comment = {};                  // of one line; often empty
  std::string crs;
  std::string software_version;
  // Of the result that was exported. None of a surface, whose comment says what the surface was made of.
  std::optional<ResultStamp> stamp = {};
  // A sentence about the origin of the coordinates, for a comment of one line; empty without an origin.
  std::string corner_comment() const;
  std::size_t corners() const { return static_cast<std::size_t>(dimension) + 1; }
};

struct VertexView {
  Point at;  // z is the height, if there are heights; else 0 in 2D
  PointId id;
  const std::byte* row = nullptr;
};

// A cell. The first dimension + 1 entries of the arrays are used.
struct CellView {
  static constexpr std::int64_t outside = -1, elsewhere = -2;
  TileId tile;
  int own = 0;                             // how many of its vertices its tile owns
  std::array<PointId, 4> ids{};            // source indices
  std::array<PointId, 4> images{};         // the same with the codes of offsets (src/base/image.h)
  std::array<std::uint64_t, 4> numbers{};  // of the vertices, in the order they came; formats with a vertex list
  std::array<Point, 4> at{};               // with heights; for formats without a list, and for those that want edges
  std::array<const std::byte*, 4> rows{};  // as VertexView::row; for formats without a list
  // Numbers of cells, or `outside`, or `elsewhere`: perhaps a cell of another tile. For formats that want them.
  std::array<std::int64_t, 4> neighbors{};
  bool final = true;        // surely a cell of the whole triangulation
  double longest_edge = 0;  // in the plane in 2D; for formats that want it
  // The value of each column of cells.
  std::vector<const std::byte*> values = {};
};

// vertex() and cell() are called millions of times, so errors are kept until check() or finish().
class MeshWriter {
 public:
  virtual ~MeshWriter() = default;
  virtual void vertex(const VertexView& vertex) = 0;
  virtual void cell(const CellView& cell) = 0;
  // The first error so far.
  virtual Status check() = 0;
  // Completes the file, gives it its name, and returns its bytes. Without this call nothing is left.
  virtual Result<std::uint64_t> finish() = 0;
};

using OpenedWriter = Result<std::unique_ptr<MeshWriter>>;

}  // namespace tessera::exports
