// Makes a Triangulation from a complete result folder.
#pragma once

#include <filesystem>
#include <optional>

#include "src/base/files/temporary.h"
#include "tessera/triangulation.h"

namespace tessera {

// A friend of Triangulation, which may call its private constructor.
struct TriangulationMaker {
  // `temporary`: the folder `path`, if it is to be removed with the Triangulation. Throws Failure.
  static Triangulation open(const std::filesystem::path& path, std::optional<TemporaryFolder> temporary);
};

}  // namespace tessera
