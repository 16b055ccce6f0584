// The triangles of a result's surface, as they are before they are written as files of other programs.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "src/surface/surface.h"

namespace tessera::surface {

// By their ids, the least first, the order kept.
using IdTriangle = std::array<PointId, 3>;
IdTriangle of_ids(PointId a, PointId b, PointId c);

struct Triangles {
  std::vector<IdTriangle> main;                // ascending, each as often as it is main
  std::map<IdTriangle, std::size_t> in_tiles;  // how many tiles have it
  std::map<PointId, Point> points;
  std::uint64_t handed_over = 0, undecided = 0;
  std::uint64_t added = 0;  // vertices, to make it manifold
};
Triangles triangles_of(const std::filesystem::path& result, const SurfaceOptions& options);

// Nothing when each edge has as many triangles one way as the other; else an edge where that is not so.
std::vector<PointId> open_edge(const std::vector<IdTriangle>& triangles);

// Empty when each edge has one triangle on each side at most and each vertex one fan of triangles; else what does not.
std::string not_manifold(const std::vector<IdTriangle>& triangles);

}  // namespace tessera::surface
