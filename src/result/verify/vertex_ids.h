// Nothing is lost and nothing is there twice: vertices = points - duplicates - rejects.
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

// Every vertex is one tile's own; a duplicate is no vertex, and what was kept for it is one; the counts add up.
Status check_vertex_ids(ExternalSort<OwnVertex>& own, const Manifest& manifest, std::vector<DuplicatePair> duplicates,
                        const TileSource& source);

}  // namespace tessera
