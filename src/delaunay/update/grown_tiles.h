// Splits the tiles that have grown too large in a change, before the new result is put together.
//
// The star of a point is the same in each tile that has the point and its neighbours. So a part needs its own points,
// and the vertices with which they share a cell of the tile: foreign vertices of the tile, and points of other parts.
// No tile exchanges anything. Tiles that have vertices of a split tile get new files with the same cells, because the
// owners of these vertices are others, and with them the main tiles of cells.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/delaunay/update/changed_tile.h"
#include "src/delaunay/update/parts_of_tile.h"
#include "src/result/tile_source.h"
#include "src/tiling/partition.h"

namespace tessera {

// A tile is too large when it has more own points than this: what `asked` says, or else an earlier change of the result
// (remember_limit()). At first it is twice the size of the largest tile, so that a tile is split that has doubled, and
// at least `least`, so that a small result does not grow into a result of very many tiles.
inline constexpr std::uint64_t grown_tile_least = 100'000;
std::uint64_t limit_of_tiles(const Manifest& manifest, std::uint64_t asked, std::uint64_t least = grown_tile_least);
// Returns the partition with the limit.
std::string remember_limit(const std::string& partition, std::uint64_t limit);

// What a change has made. Of tiles that the change has not concerned there is nothing.
struct ChangedTiles {
  std::map<TileId, TileEnd> ends;
  std::filesystem::path folder;  // of the new files, which are named as in a result of version 1
};

class GrownTiles {
 public:
  // `source`: the result before the change, without columns. All outlive this object.
  GrownTiles(const TileSource& source, const ChangedTiles& changed, std::stop_token stop);

  // Splits the tiles with new files that have more than `limit` own points, until each part has at most so many. In a
  // partition without order in space no tile is split. Returns the tiles that were split. Errors: those of reading.
  Result<std::set<TileId>> split(Partition& partition, std::uint64_t limit);
  // Makes the files that follow from the split in `folder`, and brings the other new files there. What an earlier
  // process has left there is removed. Errors: those of reading and writing; interrupted.
  Result<ChangedTiles> write(const Partition& partition, const std::set<TileId>& split,
                             const std::filesystem::path& folder);

 private:
  Result<StoredTile> read(TileId tile, bool cells) const;
  Result<TileEntry> write_file(TileId tile, TileKind kind, const TileMesh& mesh, std::span<const std::byte> rows) const;
  Status write_part(TileId tile, TileKind kind, const StoredTile& whole, const PartOfTile& part);
  Status write_parts(TileId tile);
  Status write_beside(TileId tile);
  TileKind kind_of(TileId tile) const;
  void find_owners(TileMesh& mesh) const;

  const TileSource& source_;
  const ChangedTiles& changed_;
  TileSource draft_;  // the new files
  std::stop_token stop_;
  const Partition* partition_ = nullptr;
  const std::set<TileId>* split_ = nullptr;
  ChangedTiles made_;
  std::set<TileId> written_;
  std::set<TileId> beside_;  // tiles that have vertices of split tiles, and are not split
};

}  // namespace tessera
