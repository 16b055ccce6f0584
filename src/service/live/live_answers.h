// Answers questions to one version of a live result, in the form in which a stored result answers them. Tile and number
// of a cell are a place in memory, which another version may give to another cell. So numbers begin where those of
// stored cells end, and nobody takes one for the other.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "src/base/ids.h"
#include "src/base/point.h"
#include "src/base/result.h"
#include "src/delaunay/live/live_version.h"
#include "src/result/query/stored_triangulation.h"
#include "src/service/questions/questions_backend.h"

namespace tessera::service {

inline constexpr std::int32_t first_in_memory = 1 << 30;

// Whether memory has what the question needs. Other questions are answered from the stored version.
inline bool is_answered_in_memory(const Question& question) {
  using About = Question::About;
  return (question.about == About::locate && !question.options.contains("cell")) || question.about == About::star ||
         question.about == About::neighbours;
}

// As StoredTriangulation::locate(): among cells that contain the point, the one whose sorted vertices come first.
// Error interrupted.
Result<std::vector<query::Cell>> live_locate(const LiveVersion& version, std::span<const Point> points,
                                             const query::AskOptions& options);
// REQUIRES: live_locate() has returned the cell for this version.
Result<query::CellDetails> live_details(const LiveVersion& version, const query::Cell& cell);
// Errors usage when the version has no such vertex.
Result<query::Star> live_star(const LiveVersion& version, PointId id);
Result<query::Neighbours> live_neighbours(const LiveVersion& version, PointId id);

}  // namespace tessera::service
