// What a surface was made of, as one line in the file of its triangles, so that the surface can be made again.
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
  SurfaceOptions options;     // except sensors, and options on which no triangle depends
};

std::string recipe_of(const SurfaceOptions& options, const Manifest& manifest);
// Returns nothing when the line is not a recipe. Error bad_input when a recipe is damaged.
Result<std::optional<Recipe>> read_recipe(std::string_view line);

}  // namespace tessera::surface
