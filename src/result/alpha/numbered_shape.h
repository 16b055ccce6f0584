// Numbers the vertices of an alpha shape, and passes vertices and simplices on in an order that no tile decides.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <stop_token>

#include "src/base/files/descriptor.h"
#include "src/base/result.h"
#include "src/result/alpha/shape_simplex.h"
#include "src/result/store/external_sort.h"

namespace tessera::alpha {

struct ShapeCounts {
  std::uint64_t vertices = 0;
  std::array<std::uint64_t, simplex_kinds> simplices{};  // by kind
  std::uint64_t of(SimplexKind kind) const { return simplices[static_cast<std::size_t>(kind)]; }
};

// Vertices are images (src/base/image.h). Gets the counts, then all vertices by id, then all simplices by kind and by
// the ids of their vertices. The numbers of vertices are their ranks.
class ShapeTaker {
 public:
  virtual ~ShapeTaker() = default;
  virtual Status begin(const ShapeCounts& counts) = 0;
  virtual Status vertex(PointId id, const Point& at) = 0;
  virtual Status simplex(SimplexKind kind, std::span<const std::uint64_t> vertices) = 0;
};

// Sorts in `memory_bytes`, and in unnamed files in `scratch`.
class NumberedShape {
 public:
  NumberedShape(int dimension, std::filesystem::path scratch, std::uint64_t memory_bytes, std::stop_token stop);
  // Not for several threads at once.
  Status add(std::span<const ShapeSimplex> simplices);
  // Calls `visit` for all simplices, in their order. The object cannot be used afterwards.
  Status for_each(const std::function<Status(const ShapeSimplex&)>& visit);
  // The object cannot be used afterwards. Errors: those of `taker`; io; interrupted.
  Status give(ShapeTaker& taker);

 private:
  // A vertex of a simplex.
  struct Corner {
    PointId id;
    std::uint64_t place = 0;  // 4 times the rank of the simplex, plus that of the corner
    Point at;
    friend bool operator<(const Corner& a, const Corner& b) { return a.id != b.id ? a.id < b.id : a.place < b.place; }
  };
  struct Numbered {
    std::uint64_t place = 0, number = 0;
    friend bool operator<(const Numbered& a, const Numbered& b) { return a.place < b.place; }
  };
  Result<ShapeCounts> spread(ExternalSort<Corner>& corners);
  Result<std::uint64_t> number(ExternalSort<Corner>& corners, ExternalSort<Numbered>& numbers, const FileHandle& file);
  Status give_vertices(ShapeTaker& taker, const FileHandle& file, std::uint64_t vertices) const;

  int dimension_;
  std::filesystem::path scratch_;
  std::uint64_t sorter_bytes_;
  std::stop_token stop_;
  ExternalSort<ShapeSimplex> simplices_;
};

}  // namespace tessera::alpha
