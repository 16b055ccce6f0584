// Finds the points of a result that are to be removed: by place, class, time or input.
#pragma once

#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/tile_source.h"
#include "src/result/voronoi/clip_region.h"

namespace tessera {

// The parts add up: a point that one of them names is selected.
struct PointSelection {
  // Closed. In 2D its heights are those of the attribute z; in a result without heights any height counts.
  std::optional<Box> box = {};
  std::vector<int> classes = {};  // values of the attribute "classification"
  // Closed, of the attribute "gps_time".
  struct Times {
    double from = 0, to = 0;
  };
  std::optional<Times> times = {};
  std::vector<std::shared_ptr<const voronoi::ClipRegion>> regions = {};  // closed, at any height
  std::vector<Manifest::Input::Ids> inputs = {};                         // source indices
  std::vector<Point> places = {};  // points with these coordinates; in 2D at any height, with z = 0

  bool empty() const {
    return !box && classes.empty() && !times && regions.empty() && inputs.empty() && places.empty();
  }
};

// Returns the vertices and duplicates that are selected, ascending. A duplicate counts by its own attributes and
// height. In a result that does not keep them (manifest.duplicate_rows_xxh3 is 0, and there are attributes), it is
// selected with its vertex. Errors: usage when the result lacks the attribute of a class or a time; those of reading
// the result; interrupted.
Result<std::vector<PointId>> select_points(const TileSource& source, const PointSelection& selection, unsigned threads,
                                           const std::stop_token& stop);

// The source indices of the points of an input: `file` is its path, as the manifest has it or as a path to the same
// place; or PATH@FIRST, with the first of the indices, where a path was read several times. Error usage when there is
// no such input, when there are several, and when the manifest does not tell the indices.
Result<Manifest::Input::Ids> ids_of_input(const std::filesystem::path& result, const Manifest& manifest,
                                          const std::string& file);

}  // namespace tessera
