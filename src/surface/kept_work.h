// The work of a step that begins from what earlier steps have kept.
#pragma once

#include <algorithm>
#include <memory>
#include <utility>

#include "src/base/stopped.h"
#include "src/surface/kept_codec.h"
#include "src/surface/step_program.h"
#include "src/surface/steps.h"

namespace tessera::surface {

// Gives a step's work access to the input and to what was kept. Thread-safe.
class KeptWork : public StepWork {
 public:
  KeptWork(std::shared_ptr<const StepInput> input, StepStore& store) : input_(std::move(input)), store_(store) {}

  const StepInput& input() const { return *input_; }
  const StepOptions& options() const { return input_->options; }
  StepStore& store() const { return store_; }
  bool is_first(TileId tile) const { return tile == input_->tiles.front(); }
  // Returns what was kept of a tile. Error corrupt when the bytes are something else.
  template <class What>
  Result<What> kept(StepOutput kind, TileId tile) const {
    throw_if_stopped(input_->stop);
    BOOST_OUTCOME_TRY(bytes, store_.read(kind, tile));
    What what;
    if (!read(bytes, what)) return damaged(tile, "state");
    return what;
  }
  Result<PieceInbox> kept_mail(StepOutput kind, TileId tile) const {
    BOOST_OUTCOME_TRY(bytes, store_.read(kind, tile));
    PieceInbox mail;
    if (!mail.load(bytes)) return damaged(tile, "mail");
    return mail;
  }

 private:
  std::shared_ptr<const StepInput> input_;
  StepStore& store_;
};

}  // namespace tessera::surface
