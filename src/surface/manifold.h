// A surface without edges of more than two triangles, and with one fan of triangles at each vertex: for programs that
// take no others. No vertex moves. A vertex gets a copy for each fan but its first. Where two fans that belong together
// touch themselves along an edge, copies of its ends do not tell them apart: all pairs of triangles at it but the first
// get a vertex of their own in the middle of the edge. New vertices stand a little aside. After A. Gueziec, G. Taubin,
// F. Lazarus and W. Horn, Cutting and stitching, IEEE TVCG 2001, where the outside tells what belongs together.
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

class Manifold {
 public:
  // Of a tile. For several threads at once.
  void add(Splits splits);
  // When all tiles have been added: new vertices have the ids from `first` on, in an order that no tiling changes.
  void settle(PointId first);
  std::uint64_t new_vertices() const { return new_vertices_; }
  // A tile of triangles with what is to be split. After settle().
  StoredTile apply(StoredTile tile, TileId self) const;

 private:
  struct NewVertex {
    PointId id;
    Point at;
  };
  // Of a triangle's edge, which lacks the vertex `opposite`: the vertex in the middle.
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
