// A tile as an actor: TileState behind messages.
//
// state   | message      | effect                                             | answer to the node
// any     | Batch        | keep the points; tell the node, once per silence    | MailNotice
// fresh   | triangulate  | triangulate, announce                               | TileReport, batches to other tiles
// awake   | splay        | process all mail                                    | TileReport, batches to other tiles
// asleep  | splay        | wake, then as above                                 | TileReport, batches to other tiles
// awake   | sleep        | write the state to scratch, free it                 | TileReport
// any     | collect      | make the mesh, have it stored; only after quiescence | TileReport, later TileStored
//
// Grants come from the node alone, which keeps at most as many under way as there are threads.
#pragma once

#include <caf/all.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "actors/protocol.h"
#include "actors/tile_state.h"

namespace tessera {

// Shared by the tiles and nodes of one process.
struct Directory {
  caf::actor node;                // whom tiles report to
  std::vector<caf::actor> tiles;  // by tile id; null where there is none
  // Where batches for a tile are sent: the tile itself, or in the harness a network that delays them.
  const caf::actor& route_to(TileId tile) const { return network ? network : tiles[tile.value]; }
  caf::actor network;
  std::function<void(const std::string&)> trace;  // when set, hears of every step

  template <class Text>
  void tell(Text text) const {
    if (trace) trace(text());
  }
};

class TileActor : public caf::event_based_actor {
 public:
  // `context` and `directory` outlive the actor system.
  TileActor(caf::actor_config& config, Peer self, const TileContext& context, const Directory& directory);
  caf::behavior make_behavior() override;

 private:
  void work(Work work);
  TileReport perform(Work work);
  void store();

  Peer self_;
  const Directory& directory_;
  const TileContext& context_;
  TileState state_;
  std::optional<TileMesh> mesh_;  // made, not yet handed to the storage
  bool told_node_ = false;        // of waiting mail
};

}  // namespace tessera
