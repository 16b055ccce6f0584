// From a result folder that is complete to a Triangulation.
#pragma once

#include <filesystem>
#include <optional>

#include "src/base/files/temporary.h"
#include "tessera/triangulation.h"

namespace tessera {

// Has access to the inside of a Triangulation.
struct TriangulationMaker {
  // `temporary`: `path`, when it is to go with the Triangulation.
  static Triangulation open(const std::filesystem::path& path, std::optional<TemporaryFolder> temporary);
};

}  // namespace tessera
