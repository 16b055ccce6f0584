// The outline of a 2D alpha shape as polygons: one for each piece of the shape, with its holes.
//
// Polygons are valid (OGC 06-103r4). A piece of the shape is what hangs together by edges. So its interior is
// connected, and polygons touch each other at vertices at most. A ring passes a vertex once: where a part of a piece
// touches another part of it at a vertex, what they enclose becomes a hole that touches the outer ring there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <stop_token>
#include <tuple>
#include <vector>

#include "src/base/disjoint_sets.h"
#include "src/base/files/descriptor.h"
#include "src/base/result.h"
#include "src/result/alpha/tile_outline.h"
#include "src/result/export/output.h"
#include "src/result/store/external_sort.h"

namespace tessera::alpha {

// The first ring is the outer one, counterclockwise; the others are holes, clockwise. A ring begins with its vertex of
// the least id, and does not repeat it at the end.
using OutlineRings = std::vector<std::vector<OutlineVertex>>;

// Keeps the vertices in unnamed files. Memory holds what is open at borders of tiles, some 80 bytes for each chain and
// 8 for each piece that tiles share, and one ring or polygon at a time.
class Outlines {
 public:
  Outlines(std::filesystem::path scratch, std::uint64_t memory_bytes, std::stop_token stop);
  // Not for several threads at once.
  Status add(const TileOutline& outline);
  // Calls `visit` for all polygons, ordered by the least ids of their outer rings. The object cannot be used
  // afterwards. Errors: corrupt when chains of the tiles do not fit together; those of `visit`; io; interrupted.
  Status for_each(const std::function<Status(const OutlineRings&)>& visit);

 private:
  // A part of a scratch file.
  struct Stored {
    std::uint64_t offset = 0, count = 0;  // in bytes, and in vertices
  };
  // An unnamed file that is made when it is first written.
  class VertexFile {
   public:
    explicit VertexFile(std::filesystem::path scratch) : scratch_(std::move(scratch)) {}
    Result<Stored> add(std::span<const OutlineVertex> vertices);
    Status read(const Stored& stored, std::vector<OutlineVertex>& to);  // appends

   private:
    std::filesystem::path scratch_;
    FileHandle file_;
    std::unique_ptr<exports::Stream> stream_;
  };
  struct OpenChain {
    OutlineEdge first{}, last{};
    Stored vertices;
    std::uint64_t piece = 0;
    bool done = false;
  };
  struct PieceCell {
    std::array<PointId, 3> ids{};
    std::uint32_t piece = 0;
    friend bool operator<(const PieceCell& a, const PieceCell& b) {
      return a.ids != b.ids ? a.ids < b.ids : a.piece < b.piece;
    }
  };
  struct Ring {
    OutlineEdge group{};  // of rings that belong together: a piece; or the first edge of the polygon's outer ring
    bool hole = false;
    OutlineEdge first{};  // the first edge
    Stored vertices;
    friend bool operator<(const Ring& a, const Ring& b) {
      return std::tie(a.group, a.hole, a.first) < std::tie(b.group, b.hole, b.first);
    }
  };

  Status add_walk(std::span<const OutlineVertex> walk, std::uint64_t piece);
  Status add_ring(std::vector<OutlineVertex> ring, std::uint64_t piece);
  Status join_pieces();
  Status join_chains();
  Status group_by_piece(ExternalSort<Ring>& to);
  Status group_by_polygon(ExternalSort<Ring>& from, ExternalSort<Ring>& to);

  std::filesystem::path scratch_;
  std::uint64_t sorter_bytes_;
  std::stop_token stop_;
  VertexFile chain_file_, ring_file_;
  std::vector<OpenChain> chains_;
  DisjointSets shared_pieces_;
  std::uint64_t pieces_alone_ = 0;
  ExternalSort<PieceCell> cells_;
  ExternalSort<Ring> rings_;
};

}  // namespace tessera::alpha
