// What stands between a result and a file format: a writer is told the head, then every vertex, then every cell.
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

namespace tessera::exports {

// An attribute of the vertices that the file is to hold.
struct Column {
  std::string name;
  AttributeType type = AttributeType::f64;
  std::size_t offset = 0;  // in VertexView::row
};

// A tile's share of a file.
struct Part {
  TileId tile;
  std::uint64_t vertices = 0, cells = 0;
};

struct MeshHead {
  int dimension = 3;
  bool heights = false;  // 2D: points have a z that is no part of the triangulation
  std::uint64_t vertices = 0, cells = 0;
  std::vector<Part> parts;  // vertices and cells come in their order
  std::uint64_t ids = 0;    // every id is less
  bool neighbors = false;
  bool final = false;  // of a part of a triangulation: CellView::final says something
  bool spatial_index = true;
  std::optional<Point> corner = {};  // that coordinates count from, for a comment
  std::vector<Column> columns;
  std::vector<Attribute> cell_columns = {};  // formats that hold values of cells
  std::string comment = {};                  // of one line; often empty
  std::string crs;
  std::string software_version;
  // A sentence about the corner for a comment of one line; empty without one.
  std::string corner_comment() const;
  std::size_t corners() const { return static_cast<std::size_t>(dimension) + 1; }
};

struct VertexView {
  Point at;  // z: the height, if there are heights; else 0 in 2D
  PointId id;
  const std::byte* row = nullptr;
};

// The first dimension + 1 entries count.
struct CellView {
  static constexpr std::int64_t outside = -1, elsewhere = -2;
  TileId tile;
  int own = 0;                             // how many of its vertices its tile owns
  std::array<PointId, 4> ids{};            // source indices
  std::array<std::uint64_t, 4> numbers{};  // of the vertices, in the order they were given; formats with a vertex list
  std::array<Point, 4> at{};               // formats without one, with their heights; and those that want edges
  std::array<const std::byte*, 4> rows{};  // formats without one: as VertexView::row
  // Numbers of cells, `outside`, or `elsewhere`: perhaps a cell of another tile. Formats that want them.
  std::array<std::int64_t, 4> neighbors{};
  bool final = true;        // for sure a cell of the whole triangulation
  double longest_edge = 0;  // in the plane in 2D; formats that want it
  // By column of cells: its value.
  std::vector<const std::byte*> values = {};
};

// Errors are kept until check() or finish(): vertex() and cell() are called millions of times.
class MeshWriter {
 public:
  virtual ~MeshWriter() = default;
  virtual void vertex(const VertexView& vertex) = 0;
  virtual void cell(const CellView& cell) = 0;
  // The first error so far.
  virtual Status check() = 0;
  // Completes the file under its name and returns its bytes; without this call nothing is left.
  virtual Result<std::uint64_t> finish() = 0;
};

using OpenedWriter = Result<std::unique_ptr<MeshWriter>>;

}  // namespace tessera::exports
