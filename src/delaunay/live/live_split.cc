#include "src/delaunay/live/live_split.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "src/delaunay/update/parts_of_tile.h"
#include "src/tiling/refine.h"
#include "src/tiling/routed_cloud.h"

namespace tessera {
namespace {

// Of a version.
class Splitter {
 public:
  Splitter(const LiveVersion& version, const KnownFromStart& around)
      : version_(version), around_(around), partition_(version.partition()) {}

  // Returns whether the tile was divided.
  bool divide(TileId tile, std::uint64_t limit) {
    std::vector<Point> own;
    for (const LocalPoint& p : version_.tiles()[tile.value]->triangulation().own()) own.push_back(p.at);
    if (!split_by_sample(partition_, tile, std::move(own), 1, limit)) return false;
    split_.insert(tile);
    return true;
  }

  Result<LiveSplit> build() {
    out_.tiles = version_.tiles();
    out_.tiles.resize(partition_.tiles());
    for (const TileId tile : split_) {
      BOOST_OUTCOME_TRYV(build_parts(tile));
    }
    change_owners();
    out_.partition = std::make_shared<const Partition>(std::move(partition_));
    return std::move(out_);
  }

 private:
  TileId owner_of(TileId owner, const Point& at) const {
    return split_.contains(owner) ? partition_.tile_of(at) : owner;
  }

  Status build_parts(TileId tile) {
    const TileTriangulation& whole = version_.tiles()[tile.value]->triangulation();
    const LoadedTile ordered = order_points(whole.own(), partition_.dimension());
    std::vector<LocalPoint> order;
    for (std::size_t i = 0; i < ordered.ids.size(); ++i) order.push_back({ordered.points[i], ordered.ids[i]});
    TileMesh mesh = whole.mesh(order);
    for (std::size_t v = 0; v < mesh.owners.size(); ++v) {
      mesh.owners[v] = owner_of(mesh.owners[v], mesh.points[v]);
      out_.concerned.insert(mesh.owners[v]);
    }
    for (const auto& [number, part] : parts_of(mesh)) {
      LiveTilePoints points{
          .self = number, .dimension = partition_.dimension(), .points = {}, .ids = {}, .foreign = {}};
      for (const std::int32_t v : part.own) {
        points.points.push_back(mesh.points[v]);
        points.ids.push_back(mesh.ids[v]);
      }
      for (const std::int32_t v : part.foreign)
        points.foreign.push_back({mesh.points[v], mesh.ids[v], mesh.owners[v], 0});
      auto built = build_live_tile(std::move(points), around_);
      if (!built)
        return error(built.error().code,
                     "a part of tile " + to_string(tile) + ", which has grown too large: " + built.error().where);
      out_.tiles[number.value] = std::move(built).value();
    }
    return success();
  }

  // Also of foreign vertices that are in none of a tile's cells any more.
  void change_owners() {
    for (std::size_t i = 0; i < version_.tiles().size(); ++i) {
      const auto& tile = version_.tiles()[i];
      if (!tile || split_.contains(TileId{static_cast<std::uint32_t>(i)})) continue;
      const auto foreign = tile->triangulation().foreign_vertices();
      if (std::none_of(foreign.begin(), foreign.end(), [&](const SharedPoint& p) { return split_.contains(p.tile); }))
        continue;
      auto copy = tile->triangulation().clone();
      copy->change_owners([&](TileId owner, const Point& at) { return owner_of(owner, at); });
      out_.tiles[i] = std::make_shared<const LiveTile>(std::move(copy));
    }
  }

  const LiveVersion& version_;
  const KnownFromStart& around_;
  Partition partition_;
  std::set<TileId> split_;
  LiveSplit out_;
};

}  // namespace

Result<std::optional<LiveSplit>> split_grown(const LiveVersion& version, const std::set<TileId>& changed,
                                             std::uint64_t limit, const KnownFromStart& around) {
  std::optional<LiveSplit> out;
  if (version.partition().kind() == PartitionKind::random) return out;
  Splitter splitter(version, around);
  bool any = false;
  for (const TileId tile : changed) {
    const auto& there = version.tiles()[tile.value];
    if (there && there->triangulation().own_points() > limit) any |= splitter.divide(tile, limit);
  }
  if (!any) return out;
  BOOST_OUTCOME_TRY(built, splitter.build());
  out = std::move(built);
  return out;
}

}  // namespace tessera
