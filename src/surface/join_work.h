// The steps in which tiles decide together (groups.h), and what they have decided of a tile's cells.
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
  JoinWork(std::shared_ptr<const StepInput> input, StepStore& store, Step step)
      : KeptWork(std::move(input), store), step_(step) {}
  Status tell(TileId, PieceOutbox&) const override { return success(); }
  Result<Bytes> end(TileId self, const PieceInbox& told) const override;

 private:
  Step step_;
};

// After the step cut. Of the cells that a tile could not decide alone, in its order: those on the source's side.
// `undecided`: how many there are.
Result<cut::CellSet> decided_together(const KeptWork& work, TileId self, std::uint64_t undecided);

}  // namespace tessera::surface
