// The question neighbours: which vertices share an edge with a vertex. The answer as text for people, or as one line of
// JSON.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "src/result/query/stored_triangulation.h"

namespace tessera::query {

struct Neighbours {
  PointId asked;             // the source index of the question
  PointId vertex;            // for a duplicate the kept point; else the same
  std::vector<PointId> ids;  // source indices, ascending
  bool on_hull = false;
  bool final = true;  // these are all neighbours in the whole triangulation, too
};

// The neighbours of a vertex. Errors and arguments: as StoredTriangulation::star().
Result<Neighbours> neighbours(const StoredTriangulation& stored, PointId id, std::optional<TileId> owner,
                              const AskOptions& options);

// `part` is true for a region; then the answer says whether it is final.
std::string text_of(const Neighbours& found, bool part = false);
std::string json_of(const Neighbours& found, bool part = false);

}  // namespace tessera::query
