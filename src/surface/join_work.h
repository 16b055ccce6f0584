// The steps in which tiles decide together (groups.h), and what these steps have decided of a tile's cells.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>

#include "src/surface/cut/cut_graph.h"
#include "src/surface/kept_work.h"

namespace tessera::surface {

class JoinWork final : public KeptWork {
 public:
  // `step`: groups, districts or cut.
  JoinWork(std::shared_ptr<const StepInput> input, StepStore& store, SurfaceStageId step)
      : KeptWork(std::move(input), store), step_(step) {}
  Status tell(TileId, PieceOutbox&) const override { return success(); }
  Result<Bytes> end(TileId self, const PieceInbox& told) const override;

 private:
  SurfaceStageId step_;
};

// Valid after the step cut. Returns which of the cells that a tile could not decide alone are on the source's side, in
// the order of these cells. `undecided`: their number.
Result<cut::CellSet> decided_together(const KeptWork& work, TileId self, std::uint64_t undecided);

}  // namespace tessera::surface
