// The routing table by which a share goes. When a new table comes, the share's tiles are told of it, and take it one
// after the other. This object knows how many tiles have not taken the newest table yet, and what has changed since the
// oldest table by which a tile goes. A plain object.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "src/exchange/routing_table.h"

namespace tessera {

// Returns whether a table fits a job of so many tiles, stages and nodes. Another process may have sent the table.
bool is_table_of_job(const RoutingTable& table, std::size_t tiles, std::size_t stages, std::size_t nodes);

// Returns the weights of the tiles that the node has by the table, and 0 for all others.
std::vector<std::uint64_t> weights_on(NodeId node, const RoutingTable& table, std::vector<std::uint64_t> weights);

class FollowedTable {
 public:
  explicit FollowedTable(std::shared_ptr<const RoutingTable> table) : table_(std::move(table)) {}

  const RoutingTable& operator*() const { return *table_; }
  const RoutingTable* operator->() const { return table_.get(); }
  const std::shared_ptr<const RoutingTable>& shared() const { return table_; }
  // The changes since the oldest table by which a tile goes; null: there are none.
  const std::shared_ptr<const IncarnationChanges>& changes() const { return changes_; }

  // Goes by this table from now on.
  void set(std::shared_ptr<const RoutingTable> table) { table_ = std::move(table); }
  // Tiles that go by the present table, or by an older one, will be told of `newer`.
  void add_changes(const RoutingTable& newer) {
    changes_ = incarnation_changes_between(*table_, newer, std::move(changes_));
  }
  // So many tiles are told of the table, and have not taken it yet.
  void wait_for(std::uint32_t tiles) {
    waiting_ = tiles;
    if (tiles == 0) changes_ = nullptr;
  }
  // A tile says that it goes by the table of `epoch`. `last` is the epoch of which the tile said so before. When two
  // tables follow each other, a tile may say it twice of the second one.
  void take(Epoch& last, Epoch epoch) {
    if (epoch == table_->epoch && std::exchange(last, epoch) != epoch) --waiting_;
    if (waiting_ == 0) changes_ = nullptr;
  }
  // Returns whether all tiles go by the table.
  bool is_taken() const { return waiting_ == 0; }
  // All tiles leave, because a stage is over.
  void forget_changes() { changes_ = nullptr; }

 private:
  std::shared_ptr<const RoutingTable> table_;
  std::shared_ptr<const IncarnationChanges> changes_;
  std::uint32_t waiting_ = 0;
};

}  // namespace tessera
