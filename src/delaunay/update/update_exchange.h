// The exchange of the tiles that a change wakes, in one process. It goes in rounds: in a round every tile with mail
// splays, on several threads; the messages arrive in the next round. So all is quiet when a round sends nothing.
#pragma once

#include <map>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "src/base/result.h"
#include "src/delaunay/update/woken_tile.h"

namespace tessera {

class UpdateExchange {
 public:
  UpdateExchange(const UpdateSetting& setting, unsigned threads) : setting_(setting), threads_(threads) {}

  // Reads the tiles that the change concerns, runs the exchange until all is quiet, and builds the other tiles that
  // have lost points.
  Status run();
  // The tiles that were read.
  std::map<TileId, std::unique_ptr<WokenTile>>& tiles() { return tiles_; }

 private:
  Status read(const std::set<TileId>& wanted);
  Status read_beginners();
  Status choose_common();
  void tell_of_holes(const std::vector<TileId>& beginners);
  Status begin();
  Status round();
  void post(TileId from);
  // Calls `work` for each of these tiles, on all threads.
  template <class Work>
  Status for_each(const std::vector<TileId>& tiles, const Work& work);

  const UpdateSetting& setting_;
  unsigned threads_;
  std::map<TileId, std::unique_ptr<WokenTile>> tiles_;
  std::map<TileId, WokenTile::Mail> mail_;
  std::optional<SharedPoint> common_;
};

}  // namespace tessera
