#include "src/result/query/homes.h"

#include "src/base/files/names.h"

namespace tessera::query {

Result<Homes> Homes::of(const std::filesystem::path& out, const Manifest& manifest) {
  const auto refused = [&](const std::string& reason) {
    return error(Errc::corrupt, manifest_file(out).string() + ": " + reason);
  };
  auto partition = Partition::from_json(manifest.partition);
  if (!partition) return refused(partition.error().where);
  Homes homes;
  homes.partition_ = std::move(partition).value();
  if (manifest.tiles.empty()) return refused("has no tile with points");
  homes.stand_in_.resize(homes.partition_.tiles());
  // Tiles are numbered along the tree of splits, so tiles with near numbers are near in space.
  std::size_t next = 0;
  for (std::uint32_t t = 0; t < homes.stand_in_.size(); ++t) {
    while (next + 1 < manifest.tiles.size() && manifest.tiles[next].tile.value < t) ++next;
    homes.stand_in_[t] = manifest.tiles[next].tile;
  }
  return homes;
}

}  // namespace tessera::query
