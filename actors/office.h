// Where batches go: to a tile of this node at once, to another node's part in a parcel. One per part, made before its
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
  NetworkHandle network;                          // delays and reorders batches; delivers them to parts

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
  void post(Self* sender, Batch batch) const {
    const TileId to = batch.to.tile;
    if (hooks.network) {
      sender->send(hooks.network, caf::actor_cast<caf::actor>(parts[spec.node_of(to).value]), std::move(batch));
    } else if (tiles[to.value]) {
      sender->send(tiles[to.value], std::move(batch));
    } else {
      Parcel parcel;
      parcel.batches.push_back(std::move(batch));
      sender->send(parts[spec.node_of(to).value], std::move(parcel));
    }
  }
};

}  // namespace tessera
