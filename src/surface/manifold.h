// Makes a surface manifold: no edge has more than two triangles, and each vertex has one fan of triangles. Some
// programs accept only such surfaces. No vertex moves. Each fan of a vertex but the first gets a copy of the vertex.
// Where two fans that belong together touch along an edge, copies of its ends do not separate them: there each pair of
// triangles but the first gets a vertex of its own in the middle of the edge. New vertices stand a little aside. After
// A. Gueziec, G. Taubin, F. Lazarus and W. Horn, Cutting and stitching, IEEE TVCG 2001; here the outside decides which
// triangles belong together.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "src/surface/umbrellas.h"

namespace tessera::surface {

// Collects the splits of all tiles, then applies them.
class Manifold {
 public:
  // Adds the splits of a tile. Thread-safe.
  void add(Splits splits);
  // Numbers the new vertices, when the splits of all tiles have been added: ids from `first` on, in an order that does
  // not depend on the tiles.
  void settle(PointId first);
  std::uint64_t new_vertices() const { return new_vertices_; }
  // Returns a tile of triangles with its vertices and edges split. Thread-safe after settle().
  StoredTile apply(StoredTile tile, TileId self) const;

 private:
  struct NewVertex {
    PointId id;
    Point at;
  };
  // The vertex in the middle of a triangle's edge; the edge is the one without the vertex `opposite`.
  struct Middle {
    TriangleName triangle;
    PointId opposite;
    NewVertex vertex;
  };
  std::uint32_t copy_of(const TriangleName& triangle, PointId vertex) const;
  std::optional<NewVertex> copy_for(const TriangleName& triangle, PointId vertex) const;
  std::optional<NewVertex> middle_of(const TriangleName& triangle, PointId opposite) const;

  std::mutex mutex_;
  std::vector<SplitCorner> corners_;  // by triangle and vertex
  std::vector<PairAtEdge> pairs_;
  std::map<std::pair<PointId, std::uint32_t>, NewVertex> copies_;
  std::vector<Middle> middles_;        // by triangle and opposite vertex
  std::vector<TriangleName> touched_;  // ascending
  std::uint64_t new_vertices_ = 0;
};

}  // namespace tessera::surface
