// A tile as an actor: a TileLife that is driven by messages.
//
// message   | effect                                           | answer to the share
// Delivery  | keep the update                                  | MailNotice: the first since a report, and again after
//           |                                                  | each 64 KiB, or when the longest chain has grown
// begin     | begin the program, or go on from an image        | TileReport, updates to other tiles
// step      | process all mail                                 | TileReport, updates to other tiles
// sleep     | write the state to scratch, and free it          | TileReport
// settle    | write down what the end needs without others     | TileReport
// finish    | come to the end, and have the outcome kept       | TileReport, later TileStored from a writer
// drop      | free the state                                   | TileReport
// hand over | leave an image where other nodes find it         | TileReport
// Rejoin    | go by the new table                              | TileRejoined
// Leave     | end; when given up, remove the mail on scratch   | -; TileLeft
// Mail that cannot be kept, or an exception outside of work with a permit: TileFailed, and the tile ends.
//
// Permits come from the share alone, which has at most twice as many out as it has threads.
#pragma once

#include <memory>

#include "actors/actor_directory.h"
#include "actors/prepared.h"
#include "actors/protocol.h"
#include "actors/steady_actor.h"
#include "src/exchange/share.h"
#include "src/exchange/tile_life.h"

namespace tessera {

class TileActor : public SteadyActor<TileHandle, Pool::tiles> {
 public:
  TileActor(caf::actor_config& config, TileIncarnation self, std::shared_ptr<const Share> share,
            std::shared_ptr<const ActorDirectory> directory, const std::shared_ptr<const RoutingTable>& table);
  behavior_type make_behavior() override;
  void on_exit() override;

 private:
  void failed(const std::exception_ptr& exception) noexcept override;
  void fail(Failure failure) noexcept;
  void work(Work work);
  void rejoin();
  void post_outgoing();
  Status perform(Work work);
  void store();
  MailNotice waiting() const;

  TileIncarnation self_;
  std::shared_ptr<const Share> share_;
  std::shared_ptr<const ActorDirectory> directory_;
  TileLife life_;
  Prepared<TileFailed> last_message_;
  std::unique_ptr<Finished> finished_;  // not yet handed to the storage
  std::uint64_t bytes_told_ = 0;        // memory of the waiting mail, as the share was told
  std::uint32_t hops_told_ = 0;
  bool told_ = false, left_ = false;
};

}  // namespace tessera
