#include "src/result/verify/owners.h"

#include <string>
#include <utility>

#include "src/base/image.h"
#include "src/result/store/period.h"
#include "src/result/verify/cell_ref.h"

namespace tessera {

Owners::Owners(const Manifest& manifest) {
  if (manifest.format_version < 2) return;
  if (auto partition = Partition::from_json(manifest.partition)) partition_ = std::move(partition).value();
  period_ = period_of(manifest);
}

void Owners::look_at(const TileMesh& mesh, TileId tile, const TileSource& source) {
  if (!partition_ || wrong_) return;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    // The owner of an image is the owner of the point.
    const PeriodOffset away = mesh.offsets.empty() ? PeriodOffset{} : image::offset(mesh.offsets[i]);
    const TileId owner = partition_->tile_of(period_.shifted(mesh.points[i], PeriodOffset{} - away));
    if (mesh.owners[i] == owner) continue;
    wrong_ = wrong_tile(source, tile,
                        "vertex " + to_string(mesh.ids[i]) + " has the owner " + to_string(mesh.owners[i]) +
                            ", but by the partition it belongs to tile " + to_string(owner));
    return;
  }
}

Status Owners::finish() const { return wrong_ ? Status(*wrong_) : Status(success()); }

}  // namespace tessera
