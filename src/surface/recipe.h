// What a surface was made of, as one line that stands in the file of its triangles, so that it can be made again.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "src/base/result.h"
#include "src/result/store/tile_store.h"
#include "src/surface/surface.h"

namespace tessera::surface {

struct Recipe {
  std::string triangulation;  // its digest
  std::string sensors;        // SensorOptions::text
  SurfaceOptions options;     // but for sensors, and for what no triangle depends on
};

std::string recipe_of(const SurfaceOptions& options, const Manifest& manifest);
// Nothing when the line is of something else. Error bad_input when it is damaged.
Result<std::optional<Recipe>> read_recipe(std::string_view line);

}  // namespace tessera::surface
