#include "src/tiling/tile/rebuild.h"

#include <algorithm>
#include <string>
#include <utility>

#include "src/base/check.h"
#include "src/base/image.h"
#include "src/base/stopped.h"
#include "src/geometry/kernel/kernel.h"
#include "src/tiling/tile/collect.h"

namespace tessera {

// One kernel triangulates all points as if all were the tile's own; only the cells are told apart.
Result<TileMesh> rebuild(RebuildInput input) {
  const auto corrupt = [](const char* reason) { return error(Errc::corrupt, reason); };
  const std::size_t all = input.points.size();
  check(input.own <= all && input.ids.size() == all && input.owners.size() == all, "a tile's arrays fit together");
  for (std::size_t i = 0; i < all; ++i) {
    const std::uint32_t code = offset_code(input.ids[i]);
    if (code != offset_code(input.owners[i]) || code >= image::codes) return corrupt("a source index is too large");
  }
  try {
    const auto kernel = make_kernel(input.dimension);
    kernel->build(input.points, KeepPoints::borrowed, input.stop);
    if (kernel->dimension() < input.dimension) {
      return corrupt(input.dimension == 3 ? "all its points lie in a plane" : "all its points lie on a line");
    }
    CollectInput collect{.dimension = input.dimension,
                         .self = input.self,
                         .points = {},
                         .ids = {},
                         .cells = kernel->take_cells(),
                         .fill = {},
                         .foreign = {},
                         .finals = {},
                         .stop = input.stop};
    collect.foreign.reserve(all - input.own);
    for (std::size_t i = input.own; i < all; ++i) {
      collect.foreign.push_back({input.points[i], input.ids[i], input.owners[i], 0});
    }
    input.points.resize(input.own);
    input.ids.resize(input.own);
    collect.points = std::move(input.points);
    collect.ids = std::move(input.ids);
    TileMesh mesh = collect_cells(std::move(collect)).whole();
    if (mesh.points.size() != all) return corrupt("a foreign vertex belongs to none of its cells");
    for (std::size_t v = input.own + 1; v < all; ++v) {
      const bool same_offset = mesh.offsets.empty() || mesh.offsets[v] == mesh.offsets[v - 1];
      if (mesh.ids[v] == mesh.ids[v - 1] && same_offset) return corrupt("two foreign vertices have one id");
    }
    return mesh;
  } catch (const Stopped&) {
    return error(Errc::interrupted, "interrupted while its cells are made");
  } catch (const Unsound&) {
    return corrupt("two of its points are equal");
  } catch (const TileTooLarge& e) {
    return error(Errc::memory, e.what());
  }
}

}  // namespace tessera
