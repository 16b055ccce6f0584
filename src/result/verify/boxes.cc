#include "src/result/verify/boxes.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "src/base/files/names.h"
#include "src/tiling/partition.h"

namespace tessera {

Status check_boxes(const Manifest& manifest, const std::filesystem::path& out) {
  const std::vector<Box>& boxes = manifest.boxes;
  const auto wrong = [&](TileId tile, const std::string& reason) {
    return error(Errc::corrupt, manifest_file(out).string() + ": tile " + to_string(tile) + " " + reason);
  };
  if (!manifest.tiles.empty() && manifest.tiles.back().tile.value >= boxes.size())
    return wrong(manifest.tiles.back().tile, "has no box in the partition");
  const auto partition = Partition::from_json(manifest.partition);
  if (!partition) return error(Errc::corrupt, manifest_file(out).string() + ": " + partition.error().where);
  const std::vector<Box>& made = partition.value().boxes();
  const auto differ = std::mismatch(boxes.begin(), boxes.end(), made.begin(), made.end());
  if (differ.first == boxes.end() && differ.second == made.end()) return success();
  return wrong(TileId{static_cast<std::uint32_t>(differ.first - boxes.begin())},
               "has another box than the partition's splits make");
}

}  // namespace tessera
