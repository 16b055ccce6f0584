// Finds the receiver of an update: the tile's actor when the tile is on this node, and otherwise the share, which sends
// updates in packets. Each share has one directory, made before its tiles. Only the routes change after that, and they
// may be read from any thread. When there is a test network, all updates go through it first.
#pragma once

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "actors/protocol.h"
#include "src/exchange/share.h"

namespace tessera {

// What only the harness sets.
struct Hooks {
  std::function<void(const std::string&)> trace;  // hears of every step
  NetworkHandle network;                          // delays and reorders updates, and delivers them to shares
  std::optional<NodeId> home = {};                // of all actors of a node

  template <class Text>
  void tell(Text text) const {
    if (trace) trace(text());
  }
};

// The actors for tiles and nodes in one epoch.
struct Routes {
  std::shared_ptr<const RoutingTable> table;
  // Changes up to this table, since the oldest table that a tile here may go by.
  std::shared_ptr<const IncarnationChanges> rebirths;
  std::vector<std::pair<TileId, TileHandle>> tiles;  // those on this node, ascending
  std::vector<ShareHandle> shares;                   // shares, by node; null where there is none

  // Returns null when the tile is not on this node.
  TileHandle tile(TileId id) const {
    const auto found =
        std::lower_bound(tiles.begin(), tiles.end(), id, [](const auto& entry, TileId t) { return entry.first < t; });
    return found != tiles.end() && found->first == id ? found->second : TileHandle();
  }

  // Returns null when the node has no share, or is not numbered in this epoch, as a node of an earlier one may be.
  ShareHandle share_of(NodeId node) const { return node.value < shares.size() ? shares[node.value] : ShareHandle(); }
};

class ActorDirectory {
 public:
  NodeId self;
  ShareOptions options;
  Hooks hooks;
  ShareHandle share;  // the share, to which the tiles report
  std::chrono::steady_clock::time_point opened = std::chrono::steady_clock::now();

  std::shared_ptr<const Routes> routes() const {
    const std::lock_guard lock(mutex_);
    return routes_;
  }
  void set_routes(std::shared_ptr<const Routes> routes) {
    const std::lock_guard lock(mutex_);
    routes_.swap(routes);
  }

  // Sends an update to the tile's actor here by the newest routes, or else to the share. When the tile has another
  // incarnation by then, the receiver drops the update.
  template <class Self>
  void post(Self* sender, Update update) const {
    const auto known = routes();
    const TileHandle to = known->tile(update.to.tile);
    if (!to) {
      sender->send(share, Outgoing{std::move(update)});
    } else if (hooks.network) {
      Packet packet{self, 0, {}};
      packet.updates.push_back(std::move(update));
      sender->send(hooks.network, caf::actor_cast<caf::actor>(share), std::move(packet));
    } else {
      sender->send(to, Delivery{self, std::move(update)});
    }
  }

 private:
  mutable std::mutex mutex_;
  std::shared_ptr<const Routes> routes_;
};

}  // namespace tessera
