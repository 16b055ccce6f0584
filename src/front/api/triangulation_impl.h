// What a Triangulation holds: made by triangulate() and by Triangulation::open().
#pragma once

#include <memory>

#include "src/base/files/temporary.h"
#include "src/result/tile_source.h"
#include "tessera/triangulation.h"

namespace tessera {

struct Triangulation::Impl {
  TileSource source;
  std::shared_ptr<const TemporaryFolder> temporary;  // its folder, when it is to go with the last version of this
};

}  // namespace tessera
