// The answer to one question, for people or as one line of JSON.
#pragma once

#include <optional>
#include <string>

#include "src/base/point.h"
#include "src/result/query/stored_triangulation.h"

namespace tessera {

// Of a point: its cell, or nothing outside the hull.
// `final`: of a part of a triangulation, whether it is so in the whole; else nothing.
std::string text_of(const Point& p, int dimension, const std::optional<query::CellDetails>& details,
                    std::optional<bool> final = {});
std::string json_of(const Point& p, int dimension, const std::optional<query::CellDetails>& details,
                    std::optional<bool> final = {});

// `asked`: the source index that was asked for, of which the star's may be the kept one.
// `part`: of a triangulation; the star tells whether it is final.
std::string text_of(PointId asked, int dimension, const query::Star& star, bool part = false);
std::string json_of(PointId asked, int dimension, const query::Star& star, bool part = false);

}  // namespace tessera
