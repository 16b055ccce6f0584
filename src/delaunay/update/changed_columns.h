// The computed columns of a result whose points are changed. Columns of the tiles that have changed are computed again,
// and densities also where a vertex has got or lost duplicates. Other tiles have values of foreign vertices, which
// their owners have computed again; where such values differ, the tile gets a new file with the same cells.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <set>
#include <span>
#include <stop_token>
#include <utility>
#include <vector>

#include <tsl/robin_map.h>

#include "src/base/mix_hash.h"
#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/measure/hull_change.h"
#include "src/result/measure/made_again.h"
#include "src/result/pass.h"
#include "src/result/tile_source.h"
#include "src/tiling/tile/point_ids.h"

namespace tessera {

struct FinishedTile {
  TileEntry entry;
  std::filesystem::path file;
};

struct FinishedTiles {
  std::vector<FinishedTile> tiles;
  // Whether the convex hull may be another one now (hull_change.h). False if no column has a total, which is all that
  // depends on the hull.
  bool hull_changed = false;
};

class ChangedColumns {
 public:
  // What the change has made of the result.
  struct Change {
    const std::map<TileId, TileEntry>& changed;  // entries of the tiles that have changed, or are new
    std::set<TileId> gone;                       // tiles that have no points any more
    std::vector<DuplicatePair> duplicates;       // as they are now
  };
  // `old`: the result with its columns. `scratch`: a folder like that of a result with the files of the changed tiles,
  // without columns. `to`: a folder like that of a result of version 1, for the new files. The files in `scratch` stay
  // as they are, so that all can be done again.
  ChangedColumns(const TileSource& old, std::filesystem::path scratch, Change change, std::filesystem::path to,
                 std::stop_token stop);
  // Returns all tiles whose files are new. Errors: those of reading and of ColumnsAgain; io; interrupted.
  Result<FinishedTiles> make(unsigned threads);

 private:
  // A changed tile, in the order of its file.
  struct Made {
    std::vector<PointId> ids;
    std::vector<TileId> owners;
    PassValues values;
  };
  Status compute(unsigned threads);
  Status compute_tile(ColumnsAgain& again, std::size_t index);
  Result<PointIds> other_duplicates() const;
  Status recompute(unsigned threads);
  Status recompute_tile(ColumnsAgain& again, std::size_t index);
  std::vector<std::byte> row_of(const PassValues& values, std::size_t vertex) const;
  Status look_at_neighbour(TileId tile);
  // Puts the known values of foreign vertices into the rows of an old tile, and those of its own vertices if they were
  // computed. Returns whether any differs.
  bool patch(StoredTile& stored) const;
  Status write_patched(std::size_t index, const StoredTile& stored);
  Status write_changed(std::size_t index);
  Status finish(TileEntry entry, const PassValues& values);

  const TileSource& old_;
  TileSource draft_;  // the changed tiles, without columns
  Change change_;
  std::filesystem::path to_;
  std::stop_token stop_;
  std::size_t tail_ = 0;     // bytes of a row of the columns of vertices
  bool with_total_ = false;  // a column has one
  std::vector<Made> made_;
  std::mutex mutex_;
  std::set<TileId> neighbours_;  // unchanged tiles with foreign vertices of changed or recomputed ones, or such tiles
  std::set<TileId> recomputed_;  // unchanged tiles with vertices that have other values now
  tsl::robin_map<PointId, std::vector<std::byte>, MixHash> rows_;  // the columns of vertices, by vertex
  HullChange hull_;
  std::vector<FinishedTile> finished_;
};

}  // namespace tessera
