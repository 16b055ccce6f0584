// Where updates go: to a tile of this node at once, to another node's part in a parcel. One per part, made before its
// tiles, the same ever after. The test network, when there is one, gets everything first.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "actors/protocol.h"
#include "src/run/part.h"

namespace tessera {

// What only the harness sets.
struct Hooks {
  std::function<void(const std::string&)> trace;  // hears of every step
  NetworkHandle network;                          // delays and reorders updates; delivers them to parts

  template <class Text>
  void tell(Text text) const {
    if (trace) trace(text());
  }
};

struct Office {
  NodeId self;
  PartSpec spec;
  Hooks hooks;
  PartHandle part;                // whom the tiles report to
  std::vector<TileHandle> tiles;  // by tile; null where there is none here
  std::vector<PartHandle> parts;  // by node
  std::chrono::steady_clock::time_point opened = std::chrono::steady_clock::now();

  template <class Self>
  void post(Self* sender, Update update) const {
    const TileId to = update.to.tile;
    if (hooks.network) {
      sender->send(hooks.network, caf::actor_cast<caf::actor>(parts[spec.node_of(to).value]), std::move(update));
    } else if (tiles[to.value]) {
      sender->send(tiles[to.value], std::move(update));
    } else {
      Parcel parcel;
      parcel.updates.push_back(std::move(update));
      sender->send(parts[spec.node_of(to).value], std::move(parcel));
    }
  }
};

}  // namespace tessera
