// Checks that no point is lost and none is there twice: vertices = points - duplicates - rejects.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "src/base/result.h"
#include "src/result/store/external_sort.h"
#include "src/result/tile_source.h"

namespace tessera {

struct OwnVertex {
  PointId id;
  TileId tile;
  friend bool operator<(const OwnVertex& a, const OwnVertex& b) { return a.id != b.id ? a.id < b.id : a.tile < b.tile; }
};

// Checks that every vertex is one tile's own, that no duplicate is a vertex, that the kept point of each duplicate is
// one, and that the counts add up.
Status check_vertex_ids(ExternalSort<OwnVertex>& own, const Manifest& manifest, std::vector<DuplicatePair> duplicates,
                        const TileSource& source);

}  // namespace tessera
