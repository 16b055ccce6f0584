// The inside of a Triangulation, which triangulate() and Triangulation::open() make.
#pragma once

#include <filesystem>
#include <memory>

#include "src/base/files/temporary.h"
#include "src/result/tile_source.h"
#include "tessera/triangulation.h"

namespace tessera {

struct Triangulation::Impl {
  TileSource source;
  std::shared_ptr<const TemporaryFolder> temporary;  // the folder, if it is temporary: removed with the last owner
  std::filesystem::path version = {};  // the path that stands for the version, if it was opened by its number
};

}  // namespace tessera
