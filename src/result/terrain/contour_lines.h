// Links pieces to contour lines across the borders of tiles, with a scratch file.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <stop_token>
#include <vector>

#include "src/base/files/descriptor.h"
#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/store/external_sort.h"

namespace tessera::terrain {

// Where a line crosses an edge, given by the edge's ends, the lower one first.
struct LinePoint {
  PointId a, b;
  double x = 0, y = 0;
  std::pair<PointId, PointId> edge() const { return {a, b}; }
};
static_assert(sizeof(LinePoint) == 32);

class ContourLines {
 public:
  struct Memory {
    std::uint64_t sort_bytes = 0;
    std::uint64_t chains_bytes = 0;  // for lines that end at a tile's border, part_bytes each
  };
  static constexpr std::uint64_t chain_bytes = 96;
  // `folder` gets the scratch file. After `stop` is requested, all functions soon return the error interrupted.
  static Result<ContourLines> create(const std::filesystem::path& folder, const Memory& memory, std::stop_token stop);

  // Adds a line of a tile, with the higher side on its left. A closed line ends with its first point again. Safe to
  // call from several threads. Error memory when more lines end at borders than there is room for.
  Status add(std::int64_t level, std::span<const LinePoint> points);

  // Calls visit(level, points) for each line, ordered by level and then by first edge. An open line begins with its
  // first point; a closed one begins and ends with the point of its least edge. Successive points differ. Lines without
  // length are left out: open ones with fewer than two different points, closed ones with fewer than three. The lines
  // depend only on the triangulation, not on its tiles. The object cannot be used afterwards. REQUIRES: each line fits
  // in memory.
  Status for_each(const std::function<Status(std::int64_t level, std::span<const Point> points)>& visit);

 private:
  // A line in the scratch file.
  struct Line {
    std::int64_t level = 0;
    PointId a, b;  // the edge by which lines are sorted
    std::uint64_t first = 0, count = 0;
    bool operator<(const Line& other) const { return std::tie(level, a, b) < std::tie(other.level, other.a, other.b); }
  };
  struct Chain {
    Line line;  // sorted by its first edge
    PointId end_a, end_b;
  };

  ContourLines(FileHandle file, std::filesystem::path folder, const Memory& memory, std::stop_token stop)
      : file_(std::move(file)),
        folder_(std::move(folder)),
        chains_max_(std::max<std::uint64_t>(memory.chains_bytes / chain_bytes, 1024)),
        stop_(std::move(stop)),
        sorted_(folder_, memory.sort_bytes, stop_) {}
  Result<Line> write(std::int64_t level, std::span<const LinePoint> points);
  Status read(const Line& line, std::vector<LinePoint>& points) const;
  Status link_chains();

  FileHandle file_;
  std::filesystem::path folder_;
  std::uint64_t chains_max_;
  std::stop_token stop_;
  ExternalSort<Line> sorted_;
  std::vector<Chain> chains_;
  std::uint64_t written_ = 0;  // points
  std::unique_ptr<std::mutex> mutex_ = std::make_unique<std::mutex>();
};

}  // namespace tessera::terrain
