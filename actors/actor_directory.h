// Where updates go: to a tile of this node at once, else to the part, which sends them in parcels. One per part, made
// before its tiles; all of it but the routes is the same ever after. The test network, when there is one, gets
// everything first.
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
  NetworkHandle network;                          // delays and reorders updates; delivers them to parts
  std::optional<NodeId> home = {};                // of all actors of a node

  template <class Text>
  void tell(Text text) const {
    if (trace) trace(text());
  }
};

// Where whoever is asked for can be reached, in one epoch.
struct Routes {
  std::shared_ptr<const RoutingTable> table;
  std::shared_ptr<const IncarnationChanges> rebirths;  // up to this table, since the oldest that a tile here may go by
  std::vector<std::pair<TileId, TileHandle>> tiles;    // ascending; those here
  std::vector<ShareHandle> parts;                      // by node; null where there is none

  // Null: it is not here.
  TileHandle tile(TileId id) const {
    const auto found =
        std::lower_bound(tiles.begin(), tiles.end(), id, [](const auto& entry, TileId t) { return entry.first < t; });
    return found != tiles.end() && found->first == id ? found->second : TileHandle();
  }

  // Of a node of an earlier epoch, too, which this one may not number any more: null.
  ShareHandle part_of(NodeId node) const { return node.value < parts.size() ? parts[node.value] : ShareHandle(); }
};

class ActorDirectory {
 public:
  NodeId self;
  ShareOptions options;
  Hooks hooks;
  ShareHandle part;  // whom the tiles report to
  std::chrono::steady_clock::time_point opened = std::chrono::steady_clock::now();

  std::shared_ptr<const Routes> routes() const {
    const std::lock_guard lock(mutex_);
    return routes_;
  }
  void set_routes(std::shared_ptr<const Routes> routes) {
    const std::lock_guard lock(mutex_);
    routes_.swap(routes);
  }

  // To whoever is at home there by the newest table: if that is not the incarnation that is meant, it drops the update.
  template <class Self>
  void post(Self* sender, Update update) const {
    const auto known = routes();
    const TileHandle to = known->tile(update.to.tile);
    if (!to) {
      sender->send(part, Outgoing{std::move(update)});
    } else if (hooks.network) {
      Packet packet{self, 0, {}};
      packet.updates.push_back(std::move(update));
      sender->send(hooks.network, caf::actor_cast<caf::actor>(part), std::move(packet));
    } else {
      sender->send(to, Delivery{self, std::move(update)});
    }
  }

 private:
  mutable std::mutex mutex_;
  std::shared_ptr<const Routes> routes_;
};

}  // namespace tessera
