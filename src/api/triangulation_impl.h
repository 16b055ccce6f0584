// What a Triangulation holds: made by triangulate() and by Triangulation::open().
#pragma once

#include <optional>

#include "src/files/temporary.h"
#include "src/store/tile_store.h"
#include "tessera/triangulation.h"

namespace tessera {

struct Triangulation::Impl {
  std::filesystem::path folder;
  Manifest manifest;
  std::optional<TemporaryFolder> temporary;  // `folder`, when it is to go with this
};

}  // namespace tessera
