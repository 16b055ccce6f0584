// Formats the answer to one question, as text for people or as one line of JSON.
#pragma once

#include <optional>
#include <string>

#include "src/base/point.h"
#include "src/result/query/stored_triangulation.h"

namespace tessera {

// The cell of a point; no details means outside the hull. `final` is set for a region: whether the answer also holds in
// the whole triangulation.
std::string text_of(const Point& p, int dimension, const std::optional<query::CellDetails>& details,
                    std::optional<bool> final = {});
std::string json_of(const Point& p, int dimension, const std::optional<query::CellDetails>& details,
                    std::optional<bool> final = {});

// The star of a point. `asked` is the source index of the question; the star may be that of the kept point. `part` is
// true for a region; then the answer says whether the star is final.
std::string text_of(PointId asked, int dimension, const query::Star& star, bool part = false);
std::string json_of(PointId asked, int dimension, const query::Star& star, bool part = false);

}  // namespace tessera
