#include "src/verify/boxes.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "src/files/names.h"
#include "src/tiling/partition.h"

namespace tessera {

namespace {

// Tiles of `order` from begin to end should fill `room`.
struct Part {
  std::size_t begin, end;
  Box room;
};

}  // namespace

Status check_boxes(const Manifest& manifest, const std::filesystem::path& out) {
  const std::vector<Box>& boxes = manifest.boxes;
  const auto wrong = [&](TileId tile, const std::string& reason) {
    return error(Errc::corrupt, manifest_file(out).string() + ": tile " + to_string(tile) + " " + reason);
  };
  if (!manifest.tiles.empty() && manifest.tiles.back().tile.value >= boxes.size())
    return wrong(manifest.tiles.back().tile, "has no box in the partition");
  if (manifest.format_version > 1) {
    const auto partition = Partition::from_json(manifest.partition);
    if (!partition) return error(Errc::corrupt, manifest_file(out).string() + ": " + partition.error().where);
    const std::vector<Box>& made = partition.value().boxes();
    const auto differ = std::mismatch(boxes.begin(), boxes.end(), made.begin(), made.end());
    if (differ.first == boxes.end() && differ.second == made.end()) return success();
    return wrong(TileId{static_cast<std::uint32_t>(differ.first - boxes.begin())},
                 "has another box than the partition's splits make");
  }
  std::vector<std::uint32_t> order(boxes.size());
  for (std::uint32_t tile = 0; tile < boxes.size(); ++tile) {
    if (manifest.partition_kind == "random" && boxes[tile] != Box{})
      return wrong(TileId{tile}, "has a box that is not all of space, though the partition is random");
    order[tile] = tile;
  }
  if (boxes.empty() || manifest.partition_kind == "random") return success();

  std::vector<Part> parts{{0, boxes.size(), Box{}}};
  while (!parts.empty()) {
    const Part part = parts.back();
    parts.pop_back();
    if (part.end - part.begin == 1) {
      if (boxes[order[part.begin]] != part.room)
        return wrong(TileId{order[part.begin]}, "has a box that overlaps another or leaves a gap");
      continue;
    }
    bool cut = false;
    for (int axis = 0; axis < 3 && !cut; ++axis) {
      std::sort(order.begin() + static_cast<std::ptrdiff_t>(part.begin),
                order.begin() + static_cast<std::ptrdiff_t>(part.end), [&](std::uint32_t a, std::uint32_t b) {
                  return std::pair(boxes[a].lo[axis], boxes[a].hi[axis]) <
                         std::pair(boxes[b].lo[axis], boxes[b].hi[axis]);
                });
      // All planes across this axis at once: the parts stay as few levels deep as the tree of planes was.
      Part rest = part;
      double highest = boxes[order[part.begin]].hi[axis];
      for (std::size_t i = part.begin + 1; i < part.end; ++i) {
        const Box& box = boxes[order[i]];
        if (highest <= box.lo[axis]) {
          Part below = rest;
          below.end = rest.begin = i;
          below.room.hi[axis] = rest.room.lo[axis] = box.lo[axis];
          parts.push_back(below);
          cut = true;
        }
        highest = std::max(highest, box.hi[axis]);
      }
      if (cut) parts.push_back(rest);
    }
    if (!cut) return wrong(TileId{order[part.begin]}, "has a box that overlaps another or leaves a gap");
  }
  return success();
}

}  // namespace tessera
