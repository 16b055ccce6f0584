// Which node works on which tile of a job, and which tiles are nobody's for the moment: those of lost nodes, and those
// that were given up or handed over. Told what has happened, it makes the tables. Pure.
#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <span>
#include <vector>

#include "src/exchange/assignment.h"
#include "src/exchange/routing_table.h"

namespace tessera {

struct PlacementOptions {
  std::vector<std::uint64_t> weights;  // by tile: how much work it is; 0: there is none
  std::vector<TileId> order;           // of the tiles that there are: neighbours near each other
  // Of the coordinator that makes the tables. Epochs and incarnations of one that was replaced, and does not know it,
  // are lower.
  Term term;
};

class Placements {
 public:
  using Lives = std::function<bool(NodeId)>;

  Placements(PlacementOptions options, RoutingTable table);

  const RoutingTable& table() const { return table_; }
  const std::vector<TileId>& order() const { return options_.order; }
  std::uint64_t weight(TileId tile) const { return options_.weights[tile.value]; }
  // By node, of so many: the weight of its tiles. How many they are.
  std::vector<std::uint64_t> held(std::size_t nodes) const;
  std::vector<std::uint32_t> tiles(std::size_t nodes) const;

  // The table that the parts of an earlier coordinator go by.
  void adopt(RoutingTable table) { table_ = std::move(table); }
  // All tiles are fresh, and shared out to these, from `stage` on. REQUIRES: there is room for each.
  void begin(std::uint32_t stage, std::span<const Host> hosts);
  // The next stage: all tiles are fresh, and shared out to these anew. Changes as place().
  std::vector<Placement> begin_next_stage(const std::vector<Host>& hosts, const Lives& lives);

  // A tile has come to the end of the stage. False: it had before.
  bool store(TileId tile);
  bool is_stored(TileId tile) const { return stored_.at(tile.value); }

  // A node is lost: its tiles that are not stored will begin again elsewhere. How many.
  std::size_t lose(NodeId node);
  // Tiles that nobody has begun, and that have no node any more.
  void release(std::span<const TileId> tiles) { released_.insert(released_.end(), tiles.begin(), tiles.end()); }

  // A node was asked to give up some of its tiles, once more. Its answer counts if it was asked, and was not lost.
  void ask(NodeId node) { asked_.insert(node); }
  bool answer(NodeId node, std::span<const TileId> tiles);
  // It hands over all that it has begun. False: it does already.
  bool begin_handing(NodeId node) { return handing_.insert(node).second; }
  // It has: its tiles go on elsewhere. False: it was not about to.
  bool end_handing(NodeId node);
  bool hands_over(NodeId node) const { return handing_.contains(node); }
  // It has come while others work, and is given work first.
  void come_late(NodeId node) { late_.push_back(node); }

  // Answers are still to come: nothing is placed before.
  bool awaits() const { return !asked_.empty() || !handing_.empty(); }
  // Every tile has a node, as far as is known.
  bool complete() const { return !awaits() && lost_.empty() && released_.empty(); }
  // Tiles without a node: those that begin again first.
  const std::vector<TileId>& homeless() const { return lost_.empty() ? released_ : lost_; }

  // New incarnations of tiles that are nobody's, on hosts with room for them; the others stay homeless. `again`: how
  // many of them had begun. Then change() makes the table.
  struct Placed {
    std::vector<Placement> changes;
    std::size_t again = 0;
  };
  Placed place(const std::vector<Host>& hosts, const Lives& lives);
  // A table of the next epoch.
  const RoutingTable& change(std::span<const Placement> changes);

 private:
  std::vector<Placement> again(std::vector<TileId>& tiles, std::vector<Host> hosts, const Lives& lives,
                               bool all = true) const;

  PlacementOptions options_;
  RoutingTable table_;
  std::vector<bool> stored_;      // by tile
  std::vector<TileId> lost_;      // of lost nodes
  std::vector<TileId> released_;  // given up, or handed over
  std::multiset<NodeId> asked_;   // have not answered, each as often as it was asked
  std::set<NodeId> handing_;
  std::vector<NodeId> late_;
};

}  // namespace tessera
