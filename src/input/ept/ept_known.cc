#include "src/input/ept/ept_known.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "src/input/ept/ept_tile.h"

namespace tessera::ept {
namespace {

constexpr std::size_t kept_nodes_max = std::size_t{1} << 20;  // 32 MiB

}  // namespace

Result<std::shared_ptr<const Known>> know(const ByteSource& source) {
  const auto* far = dynamic_cast<const FarSource*>(&source);
  if (far != nullptr) {
    if (auto known = std::dynamic_pointer_cast<const Known>(far->learnt())) return known;
  }
  auto known = std::make_shared<Known>();
  BOOST_OUTCOME_TRY(info, read_info(source));
  known->info = std::move(info);
  BOOST_OUTCOME_TRY(nodes, read_nodes(source, known->info));
  known->nodes = std::move(nodes);
  if (known->nodes.empty()) return error(Errc::bad_input, source.path().string() + ": holds no points");
  if (known->info.tiles == Info::Tiles::laz) {
    BOOST_OUTCOME_TRY(first, open_tile(source, *known, known->nodes.front(), {}, 1));
    known->attributes = first->info().attributes;
  } else {
    known->attributes = attributes_of(known->info);
  }
  if (far != nullptr && known->nodes.size() <= kept_nodes_max) far->learn(known);
  return std::shared_ptr<const Known>(std::move(known));
}

Result<std::vector<FilePart>> read_parts(const ByteSource& source, double resolution) {
  BOOST_OUTCOME_TRY(known, know(source));
  const Info& info = known->info;
  const std::int32_t levels = levels_for(info, resolution);
  // LAZ and Zstandard make tiles 3 to 5 times smaller.
  const std::uint64_t smaller = info.tiles == Info::Tiles::binary ? 1 : 4;
  std::vector<FilePart> parts;
  for (const auto& node : known->nodes)
    if (node.key.level < levels)
      parts.push_back({.first = node.first,
                       .points = node.points,
                       .begin = 0,
                       .bytes = node.points * info.record_bytes / smaller,
                       .bounds = bounds_of(info, node.key)});
  return parts;
}

Status bring_parts(const ByteSource& source, std::span<const FilePart> parts) {
  if (near_bytes_max(source) == 0) return success();
  BOOST_OUTCOME_TRY(known, know(source));
  std::vector<std::filesystem::path> tiles;
  for (const auto& part : parts) {
    const auto node = std::lower_bound(known->nodes.begin(), known->nodes.end(), part.first,
                                       [](const Node& each, std::uint64_t first) { return each.first < first; });
    tiles.push_back(tile_file(known->info, node->key));
  }
  return known->files.bring(source, tiles);
}

}  // namespace tessera::ept
