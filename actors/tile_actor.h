// A tile as an actor: TileLife behind messages.
//
// message   | effect                                            | answer to the part
// Delivery  | keep the message                                  | MailNotice, once per silence, hop and 64 KiB
// begin     | begin the program, or go on from an image         | TileReport, updates to other tiles
// step      | process all mail                                  | TileReport, updates to other tiles
// sleep     | write the state to scratch, free it               | TileReport
// settle    | write down what the end can be made from alone    | TileReport
// finish    | come to the end, have what is left of it kept     | TileReport, later TileStored from a writer
// drop      | free the state                                    | TileReport
// hand over | leave an image where other nodes find it          | TileReport
// Rejoin    | go by the new table                               | TileRejoined
// Leave     | end; when given up, remove the mail on scratch    | -; TileLeft
// Mail that cannot be kept, or an exception outside of granted work: TileFailed, and the tile ends.
//
// Grants come from the part alone, which keeps at most as many under way as it has threads.
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
  TileActor(caf::actor_config& config, TileIncarnation self, std::shared_ptr<const Share> part,
            std::shared_ptr<const ActorDirectory> office, const std::shared_ptr<const RoutingTable>& table);
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
  std::shared_ptr<const Share> part_;
  std::shared_ptr<const ActorDirectory> office_;
  TileLife life_;
  Prepared<TileFailed> last_word_;
  std::unique_ptr<Finished> finished_;  // not yet handed to the storage
  std::uint64_t bytes_told_ = 0;        // of waiting mail
  std::uint32_t hops_told_ = 0;
  bool told_ = false, left_ = false;
};

}  // namespace tessera
