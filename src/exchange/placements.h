// Knows which node works on which tile of a job, and which tiles are homeless: those of lost nodes, and those that were
// given up or handed over. It is told what has happened, and makes the routing tables. A plain object without I/O and
// threads.
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
  std::vector<std::uint64_t> weights;  // by tile: how much work it is; 0: there is no such tile
  std::vector<TileId> order;           // of the existing tiles: neighbours are near each other
  // The term of the coordinator that makes the tables. A coordinator that was replaced, and does not know it, has a
  // lower term, so its epochs and incarnations are lower, too.
  Term term;
};

class Placements {
 public:
  // Tells whether a node is there and may work.
  using Lives = std::function<bool(NodeId)>;

  Placements(PlacementOptions options, RoutingTable table);

  const RoutingTable& table() const { return table_; }
  const std::vector<TileId>& order() const { return options_.order; }
  std::uint64_t weight(TileId tile) const { return options_.weights[tile.value]; }
  // The weight and the number of the tiles of each node, by node. `nodes` is the number of nodes.
  std::vector<std::uint64_t> held(std::size_t nodes) const;
  std::vector<std::uint32_t> tiles(std::size_t nodes) const;

  // Takes over the table by which the shares of an earlier coordinator go.
  void adopt(RoutingTable table) { table_ = std::move(table); }
  // Makes the first table: all tiles are fresh, at the start of `stage`, and are shared out to `hosts`. REQUIRES: some
  // host has room for each tile.
  void begin(std::uint32_t stage, std::span<const Host> hosts);
  // Goes on to the next stage: all tiles are fresh, and are shared out to `hosts` anew. Returns the changes; change()
  // makes the table, as after place().
  std::vector<Placement> begin_next_stage(const std::vector<Host>& hosts, const Lives& lives);

  // Notes that a tile has come to the end of the stage. Returns false when it had come there before.
  bool store(TileId tile);
  bool is_stored(TileId tile) const { return stored_.at(tile.value); }

  // Notes that a node is lost: its tiles that are not stored become homeless, and begin again elsewhere. Returns how
  // many tiles these are.
  std::size_t lose(NodeId node);
  // Notes that tiles which no node has begun have no node any more.
  void release(std::span<const TileId> tiles) { released_.insert(released_.end(), tiles.begin(), tiles.end()); }

  // Does the same for tiles whose nodes do not live, and for tiles that their nodes have given up, without those that
  // are stored. `given_up` is by tile; empty: none. Returns how many tiles these are.
  std::size_t release_homeless(const Lives& lives, const std::vector<bool>& given_up = {});

  // A node was asked to give up some of its tiles. A node may be asked several times, and owes one answer each time.
  // take_answer() takes the tiles that it has given up. It returns false, and ignores them, when no answer is owed: the
  // node was lost meanwhile.
  void ask(NodeId node) { asked_.insert(node); }
  bool take_answer(NodeId node, std::span<const TileId> tiles);
  // A newcomer wants work: asks each other host for what it holds, divided by the number of hosts. Returns whom to ask
  // for how much weight.
  struct Request {
    NodeId node;
    std::uint64_t weight = 0;
  };
  std::vector<Request> ask_for(NodeId newcomer, std::span<const Host> hosts);
  // The node is to hand over all tiles that it has begun. Returns false when it already does so.
  bool begin_handing(NodeId node) { return handing_.insert(node).second; }
  // The node has handed over: its tiles go on elsewhere. Returns false when the node was not asked to hand over.
  bool end_handing(NodeId node);
  bool hands_over(NodeId node) const { return handing_.contains(node); }
  // The node has come while others work. It gets the tiles that were given up before other nodes do.
  void come_late(NodeId node) { late_.push_back(node); }

  // Returns whether answers are still to come. Nothing is placed before they are there.
  bool awaits() const { return !asked_.empty() || !handing_.empty(); }
  // Returns whether every tile has a node, as far as is known.
  bool complete() const { return !awaits() && lost_.empty() && released_.empty(); }
  // Tiles without a node: those that begin again, or when there are none, those that were given up.
  const std::vector<TileId>& homeless() const { return lost_.empty() ? released_ : lost_; }

  // Places homeless tiles, as new incarnations, on hosts that have room for them. The others stay homeless. `again` is
  // the number of placed tiles that had begun. The caller then calls change(), which makes the table.
  struct Placed {
    std::vector<Placement> changes;
    std::size_t again = 0;
  };
  Placed place(const std::vector<Host>& hosts, const Lives& lives);
  // Makes the table of the next epoch, with these changes, and returns it.
  const RoutingTable& change(std::span<const Placement> changes);

 private:
  std::vector<Placement> again(std::vector<TileId>& tiles, std::vector<Host> hosts, const Lives& lives,
                               bool all = true) const;

  PlacementOptions options_;
  RoutingTable table_;
  std::vector<bool> stored_;      // by tile
  std::vector<TileId> lost_;      // tiles of lost nodes
  std::vector<TileId> released_;  // tiles that were given up, or handed over
  std::multiset<NodeId> asked_;   // nodes that owe answers, each as often as it was asked
  std::set<NodeId> handing_;
  std::vector<NodeId> late_;
};

}  // namespace tessera
