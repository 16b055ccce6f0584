// Contour lines, linked from pieces across the borders of tiles, by way of a scratch file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/files/descriptor.h"
#include "src/store/external_sort.h"

namespace tessera::terrain {

// Where a line passes an edge, which is told by its ends, the lower first.
struct LinePoint {
  PointId a, b;
  double x = 0, y = 0;
  std::pair<PointId, PointId> edge() const { return {a, b}; }
};
static_assert(sizeof(LinePoint) == 32);

class ContourLines {
 public:
  // `folder`: of the scratch file. Memory is for sorting; beside it are 64 bytes for each end of a line in a tile.
  static Result<ContourLines> create(const std::filesystem::path& folder, std::uint64_t memory_bytes);

  // A line of a tile, with what is above its level on its left. A closed one ends with its first point again. Safe to
  // call from several threads.
  Status add(std::int64_t level, std::span<const LinePoint> points);

  // Calls visit(level, points) for each line, by level and then by its first edge: its first point is where it begins,
  // of a closed one the point with the least edge, which is also its last. Points that follow each other differ; lines
  // of which less than two points are left, or three of a closed one, have no length, and are none. All lines are a
  // function of the triangulation, whatever its tiles. Ends this object's life. REQUIRES: a line fits in memory.
  Status for_each(const std::function<Status(std::int64_t level, std::span<const Point> points)>& visit);

 private:
  // Points of the scratch file.
  struct Line {
    std::int64_t level = 0;
    PointId a, b;  // the edge by which lines are sorted
    std::uint64_t first = 0, count = 0;
    bool operator<(const Line& other) const { return std::tie(level, a, b) < std::tie(other.level, other.a, other.b); }
  };
  struct Part {
    Line line;  // by its first edge
    PointId end_a, end_b;
  };

  ContourLines(FileHandle file, std::filesystem::path folder, std::uint64_t memory_bytes)
      : file_(std::move(file)), folder_(std::move(folder)), sorted_(folder_, memory_bytes) {}
  Result<Line> write(std::int64_t level, std::span<const LinePoint> points);
  Status read(const Line& line, std::vector<LinePoint>& points) const;
  Status link_parts();

  FileHandle file_;
  std::filesystem::path folder_;
  ExternalSort<Line> sorted_;
  std::vector<Part> parts_;
  std::uint64_t written_ = 0;  // points
  std::unique_ptr<std::mutex> mutex_ = std::make_unique<std::mutex>();
};

}  // namespace tessera::terrain
